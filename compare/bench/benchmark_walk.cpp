#include <tbb/task_arena.h>

#include <cmath>
#include <numeric>

#include "compare/bench/benchmark.h"
#include "compare/bench/walk_timing.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

// Of the textbook loops, too.
const WalkLimits kLimits{.max_order = kMaxOrder, .thinning = Thinning{}};
constexpr CellGrid kCells{};

struct Task {
  const char* name;
  TextbookTally tally;
  int points;
  TextbookGenerator generator = TextbookGenerator::pcg32;
};
constexpr Task kTasks[] = {
    {"walk", TextbookTally::none, 0},
    {"walk+cells", TextbookTally::cells, 0},
    {"nee1", TextbookTally::points, 1},
    {"nee16", TextbookTally::points, 16},
    {"nee64", TextbookTally::points, 64},
    {"walk+cells/engine's generator", TextbookTally::cells, 0, TextbookGenerator::engine}};

double reflected_error(const Simulation& simulation) {
  const Estimate e = batch_estimate(simulation.batches(), [](const BatchTally& b) {
    double sum = 0;
    for (const auto& order : b.energy.up) sum += order[0];
    return sum;
  });
  return e.standard_error / e.value;
}

void measure_walk(const BenchmarkStack& which, const Task& task, const BenchmarkEffort& effort,
                  std::uint64_t seed, const ReportRow& report) {
  const Stack stack = which.stack();
  Plan plan = make_plan(stack, kLimits);
  plan.isa = effort.isa;
  const Direction wi = benchmark_incident();
  const std::vector<Direction> points = benchmark_points(task.points);
  const auto simulation =
      task.tally == TextbookTally::cells
          ? std::make_unique<Simulation>(stack, plan, wi, Estimator::analog, kCells, seed)
          : std::make_unique<Simulation>(stack, plan, wi, points, seed);
  TextbookWalk textbook(which.textbook, wi, task.tally, points, seed, task.generator);

  const auto engine = [&](std::uint64_t n) { simulation->advance(simulation->walks() + n); };
  const std::uint64_t walks = calibrate(effort.repetition_seconds, engine);
  const std::uint64_t textbook_walks =
      calibrate(effort.repetition_seconds, [&](std::uint64_t n) { textbook.advance(n); });
  const std::uint64_t engine_before = simulation->collisions();
  const std::uint64_t textbook_before = textbook.result().collisions;
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { engine(walks); }, [&] { textbook.advance(textbook_walks); });
  const double collisions = static_cast<double>(simulation->collisions() - engine_before);
  const double textbook_collisions =
      static_cast<double>(textbook.result().collisions - textbook_before);

  BenchmarkRow row{.what = which.name + "/" + task.name, .kind = "walk"};
  row.seconds = times.total_first();
  row.collisions_per_second_per_core = collisions / times.total_first();
  const int targets =
      task.points ? task.points
                  : (task.tally == TextbookTally::cells ? simulation->targets().grid.cells() : 0);
  row.error = targets ? mean_target_error(*simulation, targets) : reflected_error(*simulation);
  row.baseline = describe(which.textbook.medium);
  if (task.generator == TextbookGenerator::engine)
    row.baseline.replace(row.baseline.find("pcg32"), 5, "the engine's generator");
  row.ratio_to_baseline = times.median_ratio() * collisions / textbook_collisions;
  row.extra = {
      {"walks", simulation->walks()},
      {"isa", to_text(simulation->isa())},
      {"baseline_collisions", textbook_collisions},
      {"baseline_collisions_per_second",
       textbook_collisions / std::accumulate(times.second.begin(), times.second.end(), 0.0)},
      {"cycles_per_collision", core_frequency() * times.total_first() / collisions}};
  if (task.points > 0)
    row.extra["directions_per_second"] = task.points * row.collisions_per_second_per_core.value();
  if (const auto use = simulation->lane_use()) {
    row.extra["lane_occupancy"] = use->occupancy;
    row.extra["null_collisions"] = use->null;
  }
  report(std::move(row));
}

}  // namespace

void measure_walks(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const BenchmarkStack& stack : benchmark_media())
    for (const Task& task : kTasks)
      one.execute([&] { measure_walk(stack, task, effort, seed, report); });
}

void measure_plan(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  const std::string name = "lambert_sphere_halfspace";
  const Stack stack = load_stack(name);
  for (const Estimator estimator : {Estimator::analog, Estimator::next_event})
    one.execute([&] {
      const Direction wi = benchmark_incident();
      Simulation narrow(stack, make_plan(stack, kLimits), wi, estimator, kCells, seed);
      Simulation general(stack, general_plan(stack, kLimits), wi, estimator, kCells, seed);
      const auto advance = [](Simulation& s, std::uint64_t n) { s.advance(s.walks() + n); };
      const std::uint64_t walks =
          calibrate(2 * effort.repetition_seconds, [&](std::uint64_t n) { advance(narrow, n); });
      advance(general, narrow.walks());
      const std::uint64_t before = narrow.collisions();
      const InterleavedTimes times = interleave(
          effort.repetitions, [&] { advance(narrow, walks); }, [&] { advance(general, walks); });
      // Same walks in both, so the variances of the cells compare as they are.
      const double error = mean_target_error(narrow, narrow.targets().grid.cells());
      const double general_error = mean_target_error(general, general.targets().grid.cells());
      BenchmarkRow row{.what = name + "/plan/" + to_text(estimator), .kind = "walk"};
      row.seconds = times.total_first();
      row.collisions_per_second_per_core =
          static_cast<double>(narrow.collisions() - before) / times.total_first();
      row.error = error;
      row.baseline =
          "the same walks with the general plan: three channels, unfolded, layers and "
          "media looked up";
      row.ratio_to_baseline = times.median_ratio();
      row.extra = {{"walks", narrow.walks()},
                   {"variance_ratio", general_error * general_error / (error * error)}};
      report(std::move(row));
    });
}

void measure_threads(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  const std::string name = "lambert_sphere_halfspace";
  const Stack stack = load_stack(name);
  const int threads = tbb::this_task_arena::max_concurrency();
  tbb::task_arena one(1);
  Plan plan = make_plan(stack, kLimits);
  plan.isa = effort.isa;
  const Direction wi = benchmark_incident();
  Simulation single(stack, plan, wi, Estimator::analog, kCells, seed);
  Simulation parallel(stack, plan, wi, Estimator::analog, kCells, seed);
  const auto advance = [](Simulation& s, std::uint64_t n) { s.advance(s.walks() + n); };
  const std::uint64_t walks =
      calibrate(effort.repetition_seconds, [&](std::uint64_t n) { advance(parallel, n); });
  const std::uint64_t before = parallel.collisions();
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { advance(parallel, walks); },
      [&] { one.execute([&] { advance(single, walks); }); }, wall_seconds_of);
  BenchmarkRow row{.what = name + "/threads", .kind = "walk"};
  row.seconds = times.total_first();
  row.collisions_per_second_per_core =
      static_cast<double>(parallel.collisions() - before) / times.total_first() / threads;
  row.error = mean_target_error(parallel, parallel.targets().grid.cells());
  row.baseline = "the same walks with one thread";
  row.ratio_to_baseline = times.median_ratio();
  row.extra = {{"walks", parallel.walks()}, {"threads", threads}};
  report(std::move(row));
}

}  // namespace lamella
