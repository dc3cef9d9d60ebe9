#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <limits>

#include "compare/bench/benchmark.h"
#include "phase/stack/stack_file.h"
#include "volume/plan/longest_walk.h"

namespace lamella {
namespace {

// Seconds times variance of the reflected cells together, and of the reflected energy.
struct Cost {
  double cells = 0, energy = 0;
};

Cost measure(const Stack& stack, const Plan& plan, const BenchmarkEffort& effort,
             std::uint64_t seed) {
  Simulation simulation(stack, plan, benchmark_incident(), Estimator::analog,
                        CellGrid{16, 32, true}, seed);
  const double taken = advance_for(simulation, effort.accuracy_seconds);
  const RunResult run = reduce(simulation);
  const double cells = noise_of(run.reflected.lobes[Order::all]);
  const double energy = run.reflected.total[0].standard_error;
  return {taken * cells * cells, taken * energy * energy};
}

Stack single_layer(const std::string& medium, double absorption, double thickness) {
  return parse_stack(fmt::format("[[layer]]\n{}\nalbedo = {}\nthickness = {}\n", medium,
                                 1 - absorption, to_text(thickness)),
                     "thinning", "thinning");
}

}  // namespace

void measure_thinning(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::string spheres = "medium = \"lambert_sphere\"",
                    forward = "medium = \"henyey_greenstein\"\ng = 0.8";
  struct Case {
    std::string what, medium;
    double absorption, thickness;
  };
  std::vector<Case> cases;
  for (const double absorption : {0.1, 0.01, 0.005, 0.0025, 0.001})
    cases.push_back({"lambert_sphere, half space", spheres, absorption, kInfinity});
  for (const double depth : {5, 10, 20, 40})
    cases.push_back({fmt::format("lambert_sphere, slab {:g}", depth), spheres, 0, depth});
  for (const double absorption : {0.01, 0.001})
    cases.push_back({"henyey_greenstein 0.8, half space", forward, absorption, kInfinity});
  tbb::task_arena one(1);
  for (const Case& c : cases) {
    const Stack stack = single_layer(c.medium, c.absorption, c.thickness);
    // As the plan would, if walks were always long enough.
    Plan thinned = make_plan(stack, {.max_order = kThinnedMaxOrder});
    const bool planned = thinned.thinning.is_on();
    thinned.thinning = thinning_of(stack, thinned.layers);
    Plan whole = thinned;
    whole.thinning = {};
    thinned.isa = whole.isa = effort.isa;
    const auto [with, without] = one.execute([&] {
      return std::pair{measure(stack, thinned, effort, seed),
                       measure(stack, whole, effort, seed + 1)};
    });
    for (const bool cells : {true, false}) {
      BenchmarkRow row{.what = fmt::format("thinning/{}, absorption {:g}/{}", c.what, c.absorption,
                                           cells ? "cells" : "energy"),
                       .kind = "walk"};
      row.baseline = fmt::format("walks that are not thinned; time x variance; {}",
                                 planned ? "the plan thins" : "the plan does not thin");
      row.ratio_to_baseline = cells ? without.cells / with.cells : without.energy / with.energy;
      row.extra["longest_walk"] = longest_walk(stack, thinned.layers);
      row.extra["planned"] = planned;
      report(std::move(row));
    }
  }
}

}  // namespace lamella
