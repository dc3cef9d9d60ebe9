#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <map>

#include "compare/bench/benchmark.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/builtin_stacks.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

constexpr double kTarget = 0.01;
// What lobes of all orders need for more digits.
struct Target {
  const char* name;
  double error;
};
constexpr Target kTargets[] = {{"1%", kTarget}, {"0.1%", 1e-3}, {"0.01%", 1e-4}};
constexpr const char* kLobes[] = {"order1", "order2", "order3", "order4plus", "all"};

struct LobeTime {
  double seconds;
  double reached;
};

// Runs for so long, at doubling numbers of walks, and notes when each lobe came below the target.
// Time to 1 % is the time taken, scaled by the variance: seconds (error / 1 %)^2.
std::map<std::string, LobeTime> times_to_target(const Stack& stack, Estimator estimator,
                                                double seconds, Isa isa, std::uint64_t seed) {
  Plan plan = make_plan(stack);
  plan.isa = isa;
  Simulation simulation(stack, plan, benchmark_incident(), estimator, CellGrid{}, seed);
  double taken = 0;
  std::map<std::string, LobeTime> times;
  for (std::uint64_t walks = 16 * kBatches; taken < seconds; walks *= 2) {
    taken += seconds_of([&] { simulation.advance(walks); });
    const RunResult run = reduce(simulation);
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? run.reflected : run.transmitted;
      for (int o = 0; o <= kTallyOrders; ++o) {
        const double error = noise_of(side.lobes[o]);
        if (error == 0) continue;  // no walk has met it
        const double scale = error / kTarget;
        times.insert_or_assign(std::string(reflected ? "reflect." : "transmit.") + kLobes[o],
                               LobeTime{taken * scale * scale, error});
      }
    }
  }
  return times;
}

// All lobes at once, by the solver.
void measure_solver(const char* name, const Stack& stack, Isa isa, const ReportRow& report) {
  const Plan plan = make_plan(stack);
  const Direction incident[] = {benchmark_incident()};
  for (const Target& target : kTargets) {
    BenchmarkRow row{.what = fmt::format("{}/{}/deterministic/all lobes", name, target.name),
                     .kind = "deterministic"};
    DeterministicAccuracy accuracy;
    row.seconds = seconds_of([&] {
      const auto solution = solve_deterministic(
          stack, {.tolerance = target.error / 2, .max_seconds = 15, .isa = isa});
      accuracy =
          *deterministic_runs(solution, plan, incident, CellGrid{}, target.error)[0].accuracy;
    });
    row.error = accuracy.error;
    row.extra = {{"nodes", accuracy.nodes},
                 {"modes", accuracy.modes},
                 {"bytes", accuracy.bytes},
                 {"reached", accuracy.reached}};
    report(std::move(row));
  }
}

}  // namespace

void measure_accuracy(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const char* name :
       {"lambert_sphere_halfspace", "spongecake_two_layer", "vmf_sand", "sggx_slab", "hg_slab"}) {
    const Stack stack = load_stack(name);
    std::map<std::string, LobeTime> analog;
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const auto times = one.execute([&] {
        return times_to_target(stack, estimator, effort.accuracy_seconds, effort.isa, seed);
      });
      if (estimator == Estimator::analog) analog = times;
      for (const auto& [lobe, time] : times) {
        for (const Target& target : kTargets) {
          if (target.error < kTarget && lobe.find("all") == std::string::npos) continue;
          const double scale = kTarget / target.error;
          BenchmarkRow row{
              .what = fmt::format("{}/{}/{}/{}", name, target.name, to_text(estimator), lobe),
              .kind = "walk"};
          row.seconds = time.seconds * scale * scale;
          row.error = target.error;
          row.extra = {{"extrapolated", time.reached > target.error},
                       {"error_reached", time.reached}};
          const auto base = analog.find(lobe);
          if (estimator != Estimator::analog && base != analog.end()) {
            row.baseline = "analog";
            row.ratio_to_baseline = base->second.seconds / time.seconds;
          }
          report(std::move(row));
        }
      }
    }
    one.execute([&] { measure_solver(name, stack, effort.isa, report); });
  }
}

}  // namespace lamella
