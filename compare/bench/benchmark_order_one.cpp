#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "compare/bench/benchmark.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

// Of all orders, both sides: the cells together, and the energy.
struct AllVariance {
  double cells = 0, energy = 0;

  void add(const Simulation& simulation, double share) {
    const RunResult run = reduce(simulation);
    for (const SideResult* side : {&run.reflected, &run.transmitted}) {
      for (const double se : side->lobes[Order::all].standard_error) cells += share * se * se;
      energy += share * side->total[0].standard_error * side->total[0].standard_error;
    }
  }
};

struct OrderOneTimes {
  double walks = 0, random = 0, closed = 0;
  AllVariance exact{}, counted{}, of_random{};
};

OrderOneTimes measure_first(const Stack& stack, Estimator estimator, std::uint64_t walks,
                            const BenchmarkEffort& effort, std::uint64_t seed) {
  constexpr int kSeeds = 4;
  OrderOneTimes times;
  const auto simulation_of = [&](Sampling sampling, OrderOne order_one, int k) {
    Plan plan = make_plan(stack, {.sampling = sampling, .order_one = order_one});
    plan.isa = effort.isa;
    return std::make_unique<Simulation>(stack, plan, benchmark_incident(), estimator, CellGrid{},
                                        seed + static_cast<std::uint64_t>(k));
  };
  const auto least = [](double& to, double seconds, int k) {
    to = k == 0 ? seconds : std::min(to, seconds);
  };
  for (int k = 0; k < kSeeds; ++k) {
    const auto exact = simulation_of(Sampling::rqmc, OrderOne::exact, k);
    least(times.walks, seconds_of([&] { exact->advance(walks); }), k);
    least(times.closed, seconds_of([&] { (void)exact->closed_first(); }), k);
    const auto counted = simulation_of(Sampling::rqmc, OrderOne::walked, k);
    counted->advance(walks);
    const auto random = simulation_of(Sampling::random, OrderOne::walked, k);
    least(times.random, seconds_of([&] { random->advance(walks); }), k);
    times.exact.add(*exact, 1.0 / kSeeds);
    times.counted.add(*counted, 1.0 / kSeeds);
    times.of_random.add(*random, 1.0 / kSeeds);
  }
  return times;
}

void report_first(const std::string& what, const OrderOneTimes& t, double AllVariance::*part,
                  std::uint64_t walks, const ReportRow& report) {
  const double exact = t.exact.*part, seconds = t.walks + t.closed;
  if (!(exact > 0)) return;
  BenchmarkRow row{.what = "order1/" + what, .kind = "walk"};
  row.seconds = seconds;
  row.baseline = "the same walks with order 1 counted, time x variance";
  row.ratio_to_baseline = t.counted.*part * t.walks / (exact * seconds);
  row.extra = {{"walks", walks},
               {"variance_ratio", t.counted.*part / exact},
               {"closed_seconds", t.closed},
               {"ratio_to_random", t.of_random.*part * t.random / (exact * seconds)}};
  report(std::move(row));
}

}  // namespace

void measure_order_one(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  const std::uint64_t walks = effort.accuracy_seconds < 1 ? 131072 : 1000000;
  for (const char* name :
       {"lambert_sphere_halfspace", "sggx_slab", "vmf_halfspace", "spongecake_two_layer"})
    for (const Estimator estimator : {Estimator::next_event, Estimator::analog}) {
      const Stack stack = load_stack(name);
      const OrderOneTimes times =
          one.execute([&] { return measure_first(stack, estimator, walks, effort, seed); });
      const std::string what = fmt::format("{}/{}", name, to_text(estimator));
      report_first(what + "/cells", times, &AllVariance::cells, walks, report);
      report_first(what + "/energy", times, &AllVariance::energy, walks, report);
    }
}

}  // namespace lamella
