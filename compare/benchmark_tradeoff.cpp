#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "compare/benchmark.h"
#include "compare/comparison.h"
#include "compare/model_request.h"
#include "phase/builtin_stacks.h"

namespace lamella {
namespace {

// The truth that closed forms are judged by is walked this many times longer than the estimators'
// own curves.
constexpr int kTruthFactor = 4;
constexpr int kFewestWalksPerBatch = 32;

double nanoseconds(double seconds, int cells) { return seconds * 1e9 / cells; }

// Relative root mean square of the cells' standard errors.
double noise_of(const LobeEstimate& lobe) {
  double noise = 0, signal = 0;
  for (std::size_t k = 0; k < lobe.value.size(); ++k) {
    noise += lobe.standard_error[k] * lobe.standard_error[k];
    signal += lobe.value[k] * lobe.value[k];
  }
  return signal > 0 ? std::sqrt(noise / signal) : 0;
}

BenchmarkRow row_of(const std::string& stack, const std::string& method, const char* kind,
                    double ns, double error) {
  BenchmarkRow row{.what = "tradeoff/" + stack + "/" + method, .kind = kind};
  row.ns_per_eval = ns;
  row.error = error;
  row.extra = {{"stack", stack}, {"method", method}};
  return row;
}

// One estimator at numbers of walks four times apart.
void measure_estimator(const Stack& stack, Estimator estimator, double seconds, std::uint64_t seed,
                       const ReportRow& report) {
  const CellGrid grid{};
  Simulation simulation(stack, make_plan(stack), benchmark_incident(), estimator, grid, seed);
  const int cells = simulation.targets().grid.cells();
  double taken = 0;
  for (std::uint64_t walks = kFewestWalksPerBatch * kBatches; taken < seconds; walks *= 4) {
    taken += seconds_of([&] { simulation.advance(walks); });
    const double error = noise_of(reduce(simulation).reflected.lobes[kTallyOrders]);
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

// The closed forms that claim the stack, against a long walk. With e the relative RMSE without
// noise, s the relative noise and N cells of independent noise, the mean squared difference has the
// variance (4 e^2 s^2 + 2 s^4) / N.
void measure_closed_forms(const Stack& stack, const BenchmarkEffort& effort, std::uint64_t seed,
                          const ReportRow& report) {
  Simulation truth(stack, make_plan(stack), benchmark_incident(), Estimator::analog, CellGrid{},
                   seed + 1);
  double taken = 0;
  for (std::uint64_t walks = kFewestWalksPerBatch * kBatches;
       taken < kTruthFactor * effort.accuracy_seconds; walks *= 2)
    taken += seconds_of([&] { truth.advance(walks); });
  const RunResult run = reduce(truth);
  for (const BoundModel& bound : models_for(Options{}, stack)) {
    const ProjectedLobes projected =
        project(*bound.model, *bound.info, benchmark_incident(), run.grid, true, run.channels);
    for (const LobeComparison& l : compare(run, &truth, projected, true)) {
      if (l.order != Order::all) continue;
      std::vector<double> times;
      for (int k = 0; k < effort.repetitions; ++k)
        times.push_back(nanoseconds_per_eval(*bound.model));
      std::sort(times.begin(), times.end());
      const double e = l.relative_rmse_without_noise,
                   s = noise_of(run.reflected.lobes[kTallyOrders]);
      const double cells = static_cast<double>(l.truth.size());
      const double margin = 2 * std::sqrt((4 * e * e * s * s + 2 * s * s * s * s) / cells);
      // Below the noise only the upper end is known.
      const double high = std::sqrt(e * e + margin), low = std::sqrt(std::max(0.0, e * e - margin));
      BenchmarkRow row = row_of(stack.name, bound.info->name, "closed_form",
                                times[times.size() / 2], e > 0 ? e : high);
      row.extra["error_low"] = low;
      row.extra["error_high"] = high;
      row.extra["ns_low"] = times.front();
      row.extra["ns_high"] = times.back();
      report(std::move(row));
    }
  }
}

}  // namespace

void measure_tradeoff(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const BenchmarkStack& entry : benchmark_stacks()) {
    const Stack stack = load_stack(entry.name);
    one.execute([&] {
      for (const Estimator estimator : {Estimator::analog, Estimator::next_event})
        measure_estimator(stack, estimator, effort.accuracy_seconds, seed, report);
      measure_closed_forms(stack, effort, seed, report);
    });
  }
}

}  // namespace lamella
