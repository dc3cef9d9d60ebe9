#include "compare/bench/benchmark.h"

#include <gtest/gtest.h>

#include <set>

#include "analytic/model/model.h"
#include "compare/bench/textbook_coat.h"
#include "compare/bench/textbook_models.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

constexpr std::uint64_t kWalks = 100000;

double z_score(const Estimate& engine, double value, double error) {
  return (engine.value - value) / std::hypot(engine.standard_error, error);
}

Estimate side(const Simulation& simulation, bool up) {
  return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
    double sum = 0;
    for (const auto& order : up ? b.energy.up : b.energy.down) sum += order[0];
    return up ? sum : sum + b.energy.uncollided[0];
  });
}

TEST(Benchmark, TextbookLoopsHaveTheEnginesEnergies) {
  const double limit = testing::normal_quantile(testing::test_level());
  for (const BenchmarkStack& which : benchmark_media()) {
    const Stack stack = which.stack();
    Simulation simulation(stack, make_plan(stack), benchmark_incident(), {}, 1);
    simulation.advance(kWalks);
    TextbookWalk textbook(which.textbook, benchmark_incident(), TextbookTally::none, {}, 2);
    textbook.advance(kWalks);
    const TextbookResult& r = textbook.result();
    EXPECT_LT(std::abs(z_score(side(simulation, true), r.mean_reflected(), r.reflected_error())),
              limit)
        << which.name;
    const double transmitted = r.transmitted / static_cast<double>(r.walks);
    const double error = std::sqrt(transmitted / static_cast<double>(r.walks));  // weights <= 1
    if (stack.is_open_below()) {
      EXPECT_LT(std::abs(z_score(side(simulation, false), transmitted, error)), limit)
          << which.name;
    } else {
      EXPECT_EQ(transmitted, 0) << which.name;
    }
  }
}

TEST(Benchmark, TextbookLoopsHaveTheEnginesNextEventValues) {
  const double limit = testing::normal_quantile(testing::test_level());
  const std::vector<Direction> points = benchmark_points(4);
  for (const BenchmarkStack& which : benchmark_media()) {
    const Stack stack = which.stack();
    Simulation simulation(stack, make_plan(stack), benchmark_incident(), points, 1);
    simulation.advance(kWalks);
    TextbookWalk textbook(which.textbook, benchmark_incident(), TextbookTally::points, points, 2);
    textbook.advance(kWalks);
    const TextbookResult& r = textbook.result();
    const double n = static_cast<double>(r.walks);
    for (std::size_t j = 0; j < points.size(); ++j) {
      const Estimate e = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
        double sum = 0;
        for (int o = 0; o < kTallyOrders; ++o) sum += b.f[o * points.size() + j];
        return sum;
      });
      const double mean = r.f[j] / n;
      EXPECT_LT(std::abs(z_score(e, mean, std::sqrt((r.f2[j] / n - mean * mean) / n))), limit)
          << which.name << " point " << j;
    }
  }
}

TEST(Benchmark, TextbookCellsHoldWhatIsReflected) {
  for (const BenchmarkStack& which : benchmark_media()) {
    TextbookWalk textbook(which.textbook, benchmark_incident(), TextbookTally::cells, {}, 2);
    textbook.advance(10000);
    const TextbookResult& r = textbook.result();
    double sum = 0;
    for (const double f : r.f) sum += f * kPi / static_cast<double>(r.f.size());
    EXPECT_NEAR(sum, r.reflected, 1e-9 * r.reflected) << which.name;
  }
}

TEST(Benchmark, TextbookLoopsSetUpTheirMediumOnceHoweverOftenTheyAdvance) {
  const std::vector<Direction> points = benchmark_points(4);
  for (const BenchmarkStack& which : benchmark_media())
    for (const TextbookTally tally :
         {TextbookTally::none, TextbookTally::cells, TextbookTally::points}) {
      const std::uint64_t before = textbook_media_made();
      TextbookWalk pieces(which.textbook, benchmark_incident(), tally, points, 2);
      for (int k = 0; k < 64; ++k) pieces.advance(16);
      EXPECT_EQ(textbook_media_made(), before + 1) << which.name;
      TextbookWalk whole(which.textbook, benchmark_incident(), tally, points, 2);
      whole.advance(1024);
      EXPECT_EQ(pieces.result().collisions, whole.result().collisions) << which.name;
      EXPECT_EQ(pieces.result().reflected, whole.result().reflected) << which.name;
      EXPECT_EQ(pieces.result().f, whole.result().f) << which.name;
    }
}

// A row's medium is set up once, before the clock runs, and its ratio is that of the rates at which
// the two programs collide: nothing else is in it.
TEST(Benchmark, TheTextbookLoopWithACoatAgreesWithTheEngine) {
  for (const bool spheres : {true, false}) {
    const TextbookCoatCase what{.ior = 1.5, .alpha = 0.4, .albedo = 0.8, .spheres = spheres};
    const Stack stack = parse_stack(
        std::string("[[layer]]\ninterface = \"ggx\"\nior = 1.5\nroughness = 0.4\n"
                    "masking = \"correlated\"\n") +
            (spheres ? "[[layer]]\nmedium = \"lambert_sphere\"\nthickness = inf\nalbedo = 0.8\n"
                     : "[substrate]\nalbedo = 0.8\n"),
        "coat", "coat");
    TextbookCoat textbook(what, benchmark_incident(), 1);
    textbook.advance(100000);
    Simulation engine(stack, make_plan(stack), benchmark_incident(), Estimator::analog, CellGrid{},
                      1);
    engine.advance(100000);
    const RunResult run = reduce(engine);
    const TextbookCoatResult& t = textbook.result();
    const double n = static_cast<double>(t.walks), mean = t.reflected / n;
    const Estimate reflected{mean, std::sqrt((t.reflected2 / n - mean * mean) / n)};
    EXPECT_LT(std::abs(z_score(run.reflected.total[0], reflected.value, reflected.standard_error)),
              testing::normal_quantile(testing::test_level()))
        << spheres;
    // Weights of at most 1 have no larger variance than a chance of their mean.
    const double coat = t.coat / n;
    EXPECT_LT(std::abs(z_score(run.reflected.zero[0], coat, std::sqrt(coat * (1 - coat) / n))),
              testing::normal_quantile(testing::test_level()))
        << spheres;
  }
}

TEST(Benchmark, QuickCoatRowsHaveARatio) {
  int count = 0;
  measure_coats(BenchmarkEffort::quick(), 1, [&](const BenchmarkRow& row) {
    ++count;
    EXPECT_GT(*row.ratio_to_baseline, 0) << row.what;
    if (row.what.ends_with("/walk+cells"))
      EXPECT_GT(row.extra.at("interfaces_per_walk").get<double>(), 1) << row.what;
    else
      EXPECT_GT(*row.error, 0) << row.what;
  });
  EXPECT_EQ(count, 4);
}

TEST(Benchmark, QuickWalkRowsTimeCollisionsInTheBaselineAsInTheEngine) {
  const std::uint64_t before = textbook_media_made();
  std::size_t count = 0;
  measure_walks(BenchmarkEffort::quick(), 1, [&](const BenchmarkRow& row) {
    ++count;
    const double rate = row.extra.at("baseline_collisions_per_second").get<double>();
    EXPECT_GT(row.extra.at("baseline_collisions").get<double>(), 0) << row.what;
    // Up to the spread of the few repetitions.
    EXPECT_GT(*row.ratio_to_baseline * rate, 0.25 * *row.collisions_per_second_per_core)
        << row.what;
    EXPECT_LT(*row.ratio_to_baseline * rate, 4 * *row.collisions_per_second_per_core) << row.what;
  });
  EXPECT_GT(count, 0U);
  EXPECT_EQ(textbook_media_made() - before, count) << "one medium per row, set up before its clock";
}

TEST(Benchmark, TextbookModelsHaveTheModelsValues) {
  for (const char* name : {"fon", "eon", "eon_approx", "lambert_sphere", "vmf_diffuse"})
    for (const double r : {0.02, 0.2, 0.5, 1.0}) {
      const ModelInfo& info = *find_model(name);
      Parameters parameters;
      parameters.set("albedo", Rgb(0.8));
      if (find(info.parameters, "roughness")) parameters.set("roughness", r);
      fill_defaults(info.parameters, parameters);
      const auto model = info.make(parameters, nullptr);
      const auto textbook = textbook_model(name, parameters);
      ASSERT_TRUE(textbook) << name;
      std::vector<DirectionPair> pairs;
      for (const Direction wi : benchmark_points(20))
        for (const Direction wo : benchmark_points(21)) pairs.push_back({wi, wo});
      std::vector<double> values(pairs.size());
      textbook->eval(pairs, values);
      // The textbooks' own clamps and differences cost EON's albedo 1e-7 and others rounding.
      const double allowed = std::string(name).starts_with("eon") ? 1e-7 : 1e-12;
      for (std::size_t k = 0; k < pairs.size(); ++k)
        EXPECT_NEAR(values[k], model->eval(pairs[k].wi, pairs[k].wo).g, allowed)
            << name << ' ' << r;
    }
  EXPECT_FALSE(textbook_model("chandrasekhar", {}));
}

std::vector<BenchmarkRow> all_rows() {
  const BenchmarkEffort effort = BenchmarkEffort::quick();
  std::vector<BenchmarkRow> rows;
  const ReportRow report = [&](BenchmarkRow row) { rows.push_back(std::move(row)); };
  measure_walks(effort, 1, report);
  measure_plan(effort, 1, report);
  measure_threads(effort, 1, report);
  measure_accuracy(effort, 1, report);
  measure_models(effort, 1, report);
  return rows;
}

TEST(Benchmark, RowsHaveTheContractsKeysAndNames) {
  std::set<std::string> names;
  for (const BenchmarkRow& row : all_rows()) {
    const auto json = to_json(row);
    for (const char* key : {"what", "kind", "seconds", "collisions_per_second_per_core",
                            "ns_per_eval", "error", "baseline", "ratio_to_baseline"})
      EXPECT_TRUE(json.contains(key)) << row.what << ": " << key;
    EXPECT_TRUE(row.kind == "walk" || row.kind == "deterministic" || row.kind == "closed_form")
        << row.what;
    EXPECT_EQ(json["baseline"].is_null(), json["ratio_to_baseline"].is_null()) << row.what;
    EXPECT_TRUE(json["ratio_to_baseline"].is_null() || json["ratio_to_baseline"] > 0) << row.what;
    EXPECT_TRUE(json[row.kind == "closed_form" ? "ns_per_eval" : "seconds"].is_number())
        << row.what;
    EXPECT_TRUE(names.insert(row.what).second) << row.what << " twice";
  }
  for (const BenchmarkStack& stack : benchmark_media())
    for (const char* task : {"walk", "walk+cells", "nee1", "nee16", "nee64"})
      EXPECT_TRUE(names.contains(stack.name + "/" + task)) << stack.name << " " << task;
  for (const ModelInfo& info : models()) {
    EXPECT_TRUE(names.contains("eval/" + info.name)) << info.name;
    EXPECT_TRUE(names.contains("eval_batch/" + info.name)) << info.name;
  }
}

}  // namespace
}  // namespace lamella
