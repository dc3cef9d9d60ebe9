#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "compare/bench/benchmark.h"
#include "compare/bench/textbook_coat.h"
#include "compare/bench/walk_timing.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

struct Coat {
  const char* name;
  TextbookCoatCase textbook;
};
constexpr Coat kCoats[] = {
    {"ggx_coat_lambert_sphere_halfspace", {.ior = 1.5, .alpha = 0.3, .albedo = 0.9}},
    {"ggx_coat_lambert", {.ior = 1.5, .alpha = 0.3, .albedo = 0.9, .spheres = false}}};

Stack stack_of(const Coat& coat) {
  const TextbookCoatCase& t = coat.textbook;
  std::string text = fmt::format(
      "[[layer]]\ninterface = \"ggx\"\nior = {}\nroughness = {}\nmasking = \"correlated\"\n", t.ior,
      t.alpha);
  text += t.spheres ? fmt::format(
                          "[[layer]]\nmedium = \"lambert_sphere\"\nthickness = inf\n"
                          "albedo = {}\n",
                          t.albedo)
                    : fmt::format("[substrate]\nbsdf = \"lambert\"\nalbedo = {}\n", t.albedo);
  return parse_stack(text, coat.name, coat.name);
}

void measure_coat(const Coat& coat, const BenchmarkEffort& effort, std::uint64_t seed,
                  const ReportRow& report) {
  const Stack stack = stack_of(coat);
  Plan plan = make_plan(stack, {.max_order = kMaxOrder, .thinning = Thinning{}});
  plan.isa = effort.isa;
  Simulation simulation(stack, plan, benchmark_incident(), Estimator::analog, CellGrid{}, seed);
  TextbookCoat textbook(coat.textbook, benchmark_incident(), seed);
  const auto engine = [&](std::uint64_t n) { simulation.advance(simulation.walks() + n); };
  const std::uint64_t walks = calibrate(effort.repetition_seconds, engine);
  const std::uint64_t textbook_walks =
      calibrate(effort.repetition_seconds, [&](std::uint64_t n) { textbook.advance(n); });
  const std::uint64_t before = simulation.walks();
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { engine(walks); }, [&] { textbook.advance(textbook_walks); });
  const auto walked = static_cast<double>(simulation.walks() - before);

  BenchmarkRow row{.what = std::string(coat.name) + "/walk+cells", .kind = "walk"};
  row.seconds = times.total_first();
  const TextbookCoatResult& t = textbook.result();
  const auto per_walk = [&](std::uint64_t n) {
    return static_cast<double>(n) / static_cast<double>(t.walks);
  };
  if (coat.textbook.spheres)
    row.collisions_per_second_per_core = walked * per_walk(t.events) / times.total_first();
  row.error = mean_target_error(simulation, simulation.targets().grid.cells());
  row.baseline = "textbook loop: pcg32, GGX visible normals (Heitz 2018), Fresnel, " +
                 std::string(coat.textbook.spheres ? "three-uniform cosine, frame" : "cosine law");
  row.ratio_to_baseline =
      times.median_ratio() * static_cast<double>(walks) / static_cast<double>(textbook_walks);
  row.extra = {{"walks", simulation.walks()},
               {"isa", to_text(simulation.isa())},
               {"walks_per_second", walked / times.total_first()},
               {"events_per_walk", per_walk(t.events)},
               {"interfaces_per_walk", per_walk(t.meetings)},
               {"cycles_per_walk", core_frequency() * times.total_first() / walked}};
  if (const auto use = simulation.lane_use()) {
    row.extra["lane_occupancy"] = use->occupancy;
    row.extra["null_collisions"] = use->null;
  }
  report(std::move(row));
}

// Next-event estimation in cells, against the scalar double kernel of the same estimator by time x
// variance: sets of ways out are shared by more walks on lanes.
void measure_next_event(const Coat& coat, const BenchmarkEffort& effort, std::uint64_t seed,
                        const ReportRow& report) {
  const Stack stack = stack_of(coat);
  Plan plan = make_plan(stack, {.max_order = kMaxOrder, .thinning = Thinning{}});
  const auto run_on = [&](Isa isa) {
    plan.isa = isa;
    return Simulation(stack, plan, benchmark_incident(), Estimator::next_event, CellGrid{}, seed);
  };
  Simulation lanes = run_on(effort.isa), scalar = run_on(Isa::scalar);
  const auto more = [](Simulation& s) {
    return [&s](std::uint64_t n) { s.advance(s.walks() + n); };
  };
  const std::uint64_t walks = calibrate(effort.repetition_seconds, more(lanes));
  const std::uint64_t scalar_walks = calibrate(effort.repetition_seconds, more(scalar));
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { more(lanes)(walks); }, [&] { more(scalar)(scalar_walks); });
  const int cells = lanes.targets().grid.cells();
  const auto relative_variance = [cells](const Simulation& s) {
    const double error = mean_target_error(s, cells);
    return error * error * static_cast<double>(s.walks());
  };
  BenchmarkRow row{.what = std::string(coat.name) + "/next-event/cells", .kind = "walk"};
  row.seconds = times.total_first();
  row.error = mean_target_error(lanes, cells);
  row.baseline = "scalar double kernel, next-event estimation; time x variance";
  row.ratio_to_baseline = times.median_ratio() * static_cast<double>(walks) /
                          static_cast<double>(scalar_walks) * relative_variance(scalar) /
                          relative_variance(lanes);
  row.extra = {{"walks", lanes.walks()}, {"isa", to_text(lanes.isa())}};
  report(std::move(row));
}

}  // namespace

void measure_coats(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const Coat& coat : kCoats) one.execute([&] { measure_coat(coat, effort, seed, report); });
  for (const Coat& coat : kCoats)
    one.execute([&] { measure_next_event(coat, effort, seed, report); });
}

}  // namespace lamella
