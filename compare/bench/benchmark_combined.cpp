#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <limits>

#include "compare/bench/benchmark.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

using ByOrder = std::array<double, kTallyOrders + 1>;  // and of all orders

// f of each cell and seconds times its variance.
struct CellCosts {
  std::vector<ByOrder> f, cost;
};

CellCosts measure(const Stack& stack, Estimator estimator, const BenchmarkEffort& effort,
                  std::uint64_t seed) {
  Plan plan = make_plan(stack);
  plan.isa = effort.isa;
  Simulation simulation(stack, plan, benchmark_incident(), estimator, CellGrid{}, seed);
  const double taken = advance_for(simulation, effort.accuracy_seconds);
  const RunResult run = reduce(simulation);
  CellCosts found;
  for (const SideResult* side : {&run.reflected, &run.transmitted})
    for (std::size_t k = 0; k < side->lobes[0].value.size(); ++k) {
      ByOrder f, cost;
      for (int o = 0; o <= kTallyOrders; ++o) {
        const double error = side->lobes[o].standard_error[k];
        f[o] = side->lobes[o].value[k];
        cost[o] = taken * error * error;
      }
      found.f.push_back(f);
      found.cost.push_back(cost);
    }
  return found;
}

// Where counted walks met nothing of an order their variance is that of counting: f times what it
// is per f where they met something. f is what next-event estimation found.
void complete(CellCosts& counted, const CellCosts& next_event) {
  for (int o = 0; o <= kTallyOrders; ++o) {
    double cost = 0, f = 0;
    for (std::size_t k = 0; k < counted.f.size(); ++k) {
      cost += counted.cost[k][o];
      f += next_event.f[k][o];
    }
    for (std::size_t k = 0; k < counted.f.size(); ++k)
      if (counted.f[k][o] <= 0 && next_event.f[k][o] > 0)
        counted.cost[k][o] =
            cost > 0 ? cost / f * next_event.f[k][o] : std::numeric_limits<double>::infinity();
  }
}

// Mean square of the cells' relative errors after one second, `share` of which the first has: every
// cell weighs both by their variances, as if these were known.
double mean_square(const CellCosts& a, const CellCosts& b, double share, bool by_order) {
  double sum = 0;
  std::size_t lit = 0;
  for (std::size_t k = 0; k < a.f.size(); ++k) {
    const double f = b.f[k][kTallyOrders];
    if (f <= 0) continue;
    double variance = 0;
    for (int o = by_order ? 0 : kTallyOrders; o < (by_order ? kTallyOrders : kTallyOrders + 1);
         ++o) {
      if (b.f[k][o] <= 0) continue;  // there is none
      variance += 1 / (share / a.cost[k][o] + (1 - share) / b.cost[k][o]);
    }
    sum += variance / (f * f);
    ++lit;
  }
  return lit > 0 ? sum / static_cast<double>(lit) : 0;
}

void report_combination(const std::string& name, CellCosts analog, const CellCosts& next_event,
                        const ReportRow& report) {
  complete(analog, next_event);
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
