#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "compare/bench/benchmark.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/judgement.h"
#include "compare/request/model_request.h"
#include "compare/request/stopwatch.h"
#include "compare/truth/ground_truth.h"
#include "phase/stack/builtin_stacks.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

// The truth that closed forms are judged by is walked this many times longer than the estimators'
// own curves.
constexpr int kTruthFactor = 4;
constexpr int kFewestWalksPerBatch = 32;
constexpr double kTruthTolerance = 1e-5;  // of the solver as truth

double nanoseconds(double seconds, int cells) { return seconds * 1e9 / cells; }

BenchmarkRow row_of(const std::string& stack, const std::string& method, const char* kind,
                    double ns, double error) {
  BenchmarkRow row{.what = "tradeoff/" + stack + "/" + method, .kind = kind};
  row.ns_per_eval = ns;
  row.error = error;
  row.extra = {{"stack", stack}, {"method", method}};
  return row;
}

// One estimator at numbers of walks four times apart.
void measure_estimator(const Stack& stack, Isa isa, Estimator estimator, double seconds,
                       std::uint64_t seed, const ReportRow& report) {
  const CellGrid grid{};
  Plan plan = make_plan(stack);
  plan.isa = isa;
  Simulation simulation(stack, plan, benchmark_incident(), estimator, grid, seed);
  const int cells = simulation.targets().grid.cells();
  double taken = 0;
  for (std::uint64_t walks = kFewestWalksPerBatch * kBatches; taken < seconds; walks *= 4) {
    taken += seconds_of([&] { simulation.advance(walks); });
    const double error = noise_of(reduce(simulation).reflected.lobes[Order::all]);
    if (error == 0) continue;
    BenchmarkRow row =
        row_of(stack.name, to_text(estimator), "walk", nanoseconds(taken, cells), error);
    row.seconds = taken;
    row.what += fmt::format("/{}", walks);
    row.extra["walks"] = walks;
    // The sum of squares over cells of batch variances, each with kBatches - 1 degrees of freedom:
    // its relative standard deviation is at most sqrt(2 / (kBatches - 1)), where cells go together.
    const double spread = std::sqrt(2.0 / (kBatches - 1));
    row.extra["error_low"] = error * std::sqrt(1 - 2 * spread);
    row.extra["error_high"] = error * std::sqrt(1 + 2 * spread);
    report(std::move(row));
  }
}

RunResult solved(const Stack& stack, double tolerance, double seconds, Isa isa) {
  const Direction incident[] = {benchmark_incident()};
  const DeterministicSolution solution = solve_deterministic(
      stack, {.tolerance = kSolverShare * tolerance, .max_seconds = seconds, .isa = isa});
  return deterministic_runs(solution, make_plan(stack), incident, CellGrid{}, tolerance).front();
}

// The solver at ever smaller tolerances. Its error is a bound: the truth is within it.
void measure_solver(const Stack& stack, double seconds, Isa isa, const ReportRow& report) {
  if (why_not_deterministic(stack)) return;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    RunResult run;
    const double taken = seconds_of([&] { run = solved(stack, tolerance, seconds, isa); });
    const double error = noise_of(run.reflected.lobes[Order::all]);
    if (error == 0) continue;
    BenchmarkRow row = row_of(stack.name, to_text(Estimator::deterministic), "deterministic",
                              nanoseconds(taken, run.grid.cells()), error);
    row.seconds = taken;
    row.what += fmt::format("/{:g}", tolerance);
    row.extra["tolerance"] = tolerance;
    row.extra["bound"] = true;
    row.extra["reached"] = run.accuracy->reached;
    row.extra["nodes"] = run.accuracy->nodes;
    row.extra["modes"] = run.accuracy->modes;
    row.extra["bytes"] = run.accuracy->bytes;
    report(std::move(row));
    // What the time did not allow is not to be had at a smaller tolerance.
    if (!run.accuracy->reached) return;
  }
}

// What closed forms are judged by: the solver where it is exact soon enough, else a long walk.
Truth truth_of(const Stack& stack, const BenchmarkEffort& effort, std::uint64_t seed) {
  Plan plan = make_plan(stack);
  plan.isa = effort.isa;
  Truth truth;
  if (!why_not_deterministic(stack)) {
    truth.run = solved(stack, kTruthTolerance, kTruthFactor * effort.accuracy_seconds, effort.isa);
    if (truth.run.accuracy->reached) return truth;
  }
  truth.batches = std::make_unique<Simulation>(stack, plan, benchmark_incident(), Estimator::analog,
                                               CellGrid{}, seed + 1);
  double taken = 0;
  for (std::uint64_t walks = kFewestWalksPerBatch * kBatches;
       taken < kTruthFactor * effort.accuracy_seconds; walks *= 2)
    taken += seconds_of([&] { truth.batches->advance(walks); });
  truth.run = reduce(*truth.batches);
  return truth;
}

// Ends of the interval that holds a closed form's error. Against walks: with e the relative RMSE
// without noise, s the relative noise and N cells of independent noise, the mean squared difference
// has the variance (4 e^2 s^2 + 2 s^4) / N. Against a bounded truth no more than the bound and the
// projection add.
std::pair<double, double> error_interval(const LobeComparison& l, double s) {
  const double e = l.relative_rmse_without_noise;
  if (l.bounded) return {std::max(0.0, e - s - kProjectionTolerance), e + s + kProjectionTolerance};
  const double cells = static_cast<double>(l.truth.size());
  const double margin = 2 * std::sqrt((4 * e * e * s * s + 2 * s * s * s * s) / cells);
  return {std::sqrt(std::max(0.0, e * e - margin)), std::sqrt(e * e + margin)};
}

// The closed forms that claim the stack, one pair after the other.
void measure_closed_forms(const Stack& stack, const BenchmarkEffort& effort, std::uint64_t seed,
                          const ReportRow& report) {
  for (const JudgedClosedForm& judged : judged_closed_forms(stack, effort, seed)) {
    std::vector<double> times;
    for (int k = 0; k < effort.repetitions; ++k)
      times.push_back(nanoseconds_per_eval(*judged.bound.model));
    std::sort(times.begin(), times.end());
    const auto [error, low, high] = judged.error;
    // Below the noise only the upper end is known.
    BenchmarkRow row = row_of(stack.name, judged.bound.info->name, "closed_form",
                              times[times.size() / 2], error > 0 ? error : high);
    row.extra["error_low"] = low;
    row.extra["error_high"] = high;
    row.extra["ns_low"] = times.front();
    row.extra["ns_high"] = times.back();
    report(std::move(row));
  }
}

}  // namespace

std::vector<JudgedClosedForm> judged_closed_forms(const Stack& stack, const BenchmarkEffort& effort,
                                                  std::uint64_t seed) {
  std::vector<JudgedClosedForm> list;
  const Truth truth = truth_of(stack, effort, seed);
  for (BoundModel& bound : fitted_models_for({}, stack))
    for (const LobeComparison& l : judge(truth, make_plan(stack), bound)) {
      if (l.order != Order::all || !l.reflected) continue;
      const auto [low, high] = error_interval(l, noise_of(truth.run.reflected.lobes[Order::all]));
      list.push_back({std::move(bound), {l.relative_rmse_without_noise, low, high}});
      break;
    }
  return list;
}

void measure_tradeoff(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const BenchmarkStack& entry : benchmark_stacks()) {
    const Stack stack = load_stack(entry.name);
    one.execute([&] {
      for (const Estimator estimator : {Estimator::analog, Estimator::next_event})
        measure_estimator(stack, effort.isa, estimator, effort.accuracy_seconds, seed, report);
      measure_solver(stack, kTruthFactor * effort.accuracy_seconds, effort.isa, report);
      measure_closed_forms(stack, effort, seed, report);
    });
  }
}

}  // namespace lamella
