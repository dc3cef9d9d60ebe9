#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "compare/bench/benchmark.h"
#include "compare/bench/walk_timing.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

// Flakes that lean by 27 degrees in the plane of light from 45, of optical depth 2.
constexpr double kLean = 27, kLight = 45;

Stack tilted_flakes(const char* flake, double alpha) {
  const double lean = kLean * kPi / 180;
  return parse_stack(fmt::format("[[layer]]\nmedium = \"vmf_flake\"\nflake = \"{}\"\nalpha = {}\n"
                                 "axis = [{}, 0.0, {}]\nthickness = 2\nalbedo = 0.9\n",
                                 flake, alpha, std::sin(lean), std::cos(lean)),
                     "tilted_flakes", "tilted_flakes");
}

void measure(const char* flake, double alpha, const BenchmarkEffort& effort, std::uint64_t seed,
             const ReportRow& report) {
  const Stack stack = tilted_flakes(flake, alpha);
  Plan plan = make_plan(stack);
  plan.isa = Isa::scalar;
  const Direction wi = direction_from_degrees(kLight, 0);
  const auto simulation = [&] {
    return Simulation(stack, plan, wi, Estimator::analog, CellGrid{}, seed);
  };
  Simulation scalar = simulation();
  plan.isa = effort.isa;
  Simulation lanes = simulation();
  const auto advance = [](Simulation& s, std::uint64_t n) { s.advance(s.walks() + n); };
  const auto calibrated = [&](Simulation& s) {
    return calibrate(effort.repetition_seconds, [&](std::uint64_t n) { advance(s, n); });
  };
  const std::uint64_t walks = calibrated(lanes), scalar_walks = calibrated(scalar);
  const std::uint64_t before = lanes.collisions(), scalar_before = scalar.collisions();
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { advance(lanes, walks); }, [&] { advance(scalar, scalar_walks); });
  const auto collisions = static_cast<double>(lanes.collisions() - before);
  BenchmarkRow row{.what = fmt::format("tilted vMF {} {}/walk+cells", flake, alpha),
                   .kind = "walk"};
  row.seconds = times.total_first();
  row.collisions_per_second_per_core = collisions / times.total_first();
  row.error = mean_target_error(lanes, lanes.targets().grid.cells());
  row.baseline = "the scalar kernel, as many walks";
  row.ratio_to_baseline =
      times.median_ratio() * static_cast<double>(walks) / static_cast<double>(scalar_walks);
  row.extra = {
      {"walks", lanes.walks()},
      {"isa", to_text(lanes.isa())},
      {"baseline_collisions", scalar.collisions() - scalar_before},
      {"ns_per_walk", 1e9 * times.total_first() / static_cast<double>(walks * effort.repetitions)}};
  report(std::move(row));
}

}  // namespace

void measure_tilted_flakes(const BenchmarkEffort& effort, std::uint64_t seed,
                           const ReportRow& report) {
  tbb::task_arena one(1);
  for (const char* flake : {"mirror", "lambert"})
    for (const double alpha : {0.005, 0.05, 0.2, 0.5})
      one.execute([&] { measure(flake, alpha, effort, seed, report); });
}

}  // namespace lamella
