#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <limits>

#include "compare/benchmark.h"
#include "phase/builtin_stacks.h"
#include "phase/stack_file.h"

namespace lamella {
namespace {

// Seconds times variance of each cell, by order and of all orders, and the cell's f.
struct CellCosts {
  std::vector<std::array<double, kTallyOrders + 1>> cost;
  std::vector<double> f;
};

CellCosts measure(const Stack& stack, Estimator estimator, const BenchmarkEffort& effort,
                  std::uint64_t seed) {
  Plan plan = make_plan(stack);
  plan.isa = effort.isa;
  Simulation simulation(stack, plan, benchmark_incident(), estimator, CellGrid{}, seed);
  double taken = 0;
  for (std::uint64_t walks = 16 * kBatches; taken < effort.accuracy_seconds; walks *= 2)
    taken += seconds_of([&] { simulation.advance(walks); });
  const RunResult run = reduce(simulation);
  CellCosts found;
  for (const SideResult* side : {&run.reflected, &run.transmitted})
    for (std::size_t k = 0; k < side->lobes[0].value.size(); ++k) {
      std::array<double, kTallyOrders + 1> cost{};
      for (int o = 0; o <= kTallyOrders; ++o) {
        const double error = side->lobes[o].standard_error[k];
        // What no walk has met yet costs more than what was found.
        cost[o] = error > 0 ? taken * error * error : std::numeric_limits<double>::infinity();
      }
      found.cost.push_back(cost);
      found.f.push_back(side->lobes[kTallyOrders].value[k]);
    }
  return found;
}

// Mean square of the cells' relative errors after one second, `share` of which the first has: every
// cell weighs both by their variances, as if these were known.
double mean_square(const CellCosts& a, const CellCosts& b, double share, bool by_order) {
  double sum = 0;
  std::size_t lit = 0;
  for (std::size_t k = 0; k < a.f.size(); ++k) {
    if (b.f[k] <= 0) continue;
    double variance = 0;
    for (int o = by_order ? 0 : kTallyOrders; o < (by_order ? kTallyOrders : kTallyOrders + 1);
         ++o) {
      const double known = share / a.cost[k][o] + (1 - share) / b.cost[k][o];
      if (known > 0) variance += 1 / known;
    }
    sum += variance / (b.f[k] * b.f[k]);
    ++lit;
  }
  return lit > 0 ? sum / static_cast<double>(lit) : 0;
}

void report_combination(const std::string& name, const CellCosts& analog,
                        const CellCosts& next_event, const ReportRow& report) {
  for (const bool by_order : {false, true}) {
    const double single = std::min(mean_square(analog, next_event, 1, by_order),
                                   mean_square(analog, next_event, 0, by_order));
    double best = std::numeric_limits<double>::infinity();
    for (int percent = 5; percent < 100; percent += 5)
      best = std::min(best, mean_square(analog, next_event, percent / 100.0, by_order));
    BenchmarkRow row{.what = fmt::format("combined/{}/{}", name,
                                         by_order ? "each order in each cell" : "each cell"),
                     .kind = "walk"};
    row.baseline = "the better of analog and next-event alone; at best, by time x variance";
    if (best > 0 && std::isfinite(single)) row.ratio_to_baseline = single / best;
    report(std::move(row));
  }
}

Stack narrow_mirrors(double roughness) {
  return parse_stack(fmt::format("[[layer]]\nmedium = \"sggx\"\nroughness = {}\nalbedo = 0.9\n"
                                 "thickness = 2\n",
                                 roughness),
                     "narrow", fmt::format("sggx_{:g}_slab", roughness));
}

}  // namespace

void measure_combination(const BenchmarkEffort& effort, std::uint64_t seed,
                         const ReportRow& report) {
  std::vector<Stack> stacks;
  for (const char* name :
       {"lambert_sphere_halfspace", "vmf_sand", "hg_slab", "sggx_slab", "spongecake_two_layer",
        "spongecake_plant", "spongecake_fabric", "spongecake_wood"})
    stacks.push_back(load_stack(name));
  for (const double roughness : {0.2, 0.1}) stacks.push_back(narrow_mirrors(roughness));
  tbb::task_arena one(1);
  one.execute([&] {
    for (const Stack& stack : stacks)
      report_combination(stack.name, measure(stack, Estimator::analog, effort, seed),
                         measure(stack, Estimator::next_event, effort, seed + 1), report);
  });
}

}  // namespace lamella
