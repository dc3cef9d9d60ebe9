#include "compare/exchange/measured_comparison.h"

#include <algorithm>
#include <cmath>

#include "compare/exchange/exported.h"
#include "compare/judge/judgement.h"
#include "compare/judge/projection.h"

namespace lamella {
namespace {

constexpr int kAll = kTallyOrders;  // of SideResult::lobes

// The material's cells as the run of a solver: bounds in the place of standard errors.
RunResult run_of(const Model& measured, Direction wi, const CellGrid& cells) {
  RunResult run;
  run.incident = wi;
  run.estimator = Estimator::deterministic;
  run.grid = cells;
  run.grid.folded = false;
  run.channels = 3;
  const ProjectedLobes found =
      project(measured, measured_info("measured"), wi, run.grid, true, run.channels);
  LobeEstimate& lobe = run.reflected.lobes[kAll];
  lobe.value = found.lobes[Order::all];
  lobe.standard_error = found.errors[Order::all];
  const auto n = static_cast<std::size_t>(run.grid.cells());
  DeterministicAccuracy accuracy;
  accuracy.reached = true;
  for (std::size_t k = 0; k < lobe.value.size(); ++k) {
    lobe.standard_error[k] =
        std::max(lobe.standard_error[k], kProjectionTolerance * std::abs(lobe.value[k]));
    const std::size_t c = k / n;
    run.reflected.total[c].value += lobe.value[k] * run.grid.projected_solid_angle();
    run.reflected.total[c].standard_error +=
        lobe.standard_error[k] * run.grid.projected_solid_angle();
    if (lobe.value[k] > 0)
      accuracy.error = std::max(accuracy.error, lobe.standard_error[k] / lobe.value[k]);
  }
  for (int c = 0; c < run.channels; ++c)
    run.absorbed[c] = {1 - run.reflected.total[c].value, run.reflected.total[c].standard_error};
  run.accuracy = accuracy;
  return run;
}

}  // namespace

bool is_measured_file(const std::string& name) {
  return name.ends_with(".binary") || name.ends_with(".bsdf");
}

StackComparison compare_measured(const Model& measured, const TruthRequest& request,
                                 const std::vector<BoundModel>& models, const RunMonitor& monitor) {
  StackComparison comparison;
  comparison.choice = {Estimator::deterministic, "a measured material on cells", nullptr};
  comparison.channels = 3;
  Plan plan;
  plan.channels = 3;
  plan.folded = plan.transmits = false;
  const std::vector<std::string> names = distinct_names(models);
  for (std::size_t m = 0; m < models.size(); ++m)
    comparison.models.push_back({&models[m], names[m], nanoseconds_per_eval(*models[m].model)});
  for (const Direction wi : request.directions) {
    if (monitor.is_stopped() && !comparison.runs.empty()) break;
    comparison.runs.push_back(run_of(measured, wi, request.cells));
    for (JudgedModel& m : comparison.models)
      for (LobeComparison& l : judge({comparison.runs.back(), nullptr}, plan, *m.bound))
        m.lobes.push_back(std::move(l));
  }
  std::vector<LobeComparison*> all;
  for (JudgedModel& m : comparison.models)
    for (LobeComparison& l : m.lobes) all.push_back(&l);
  decide(all);
  comparison.interrupted = monitor.is_stopped();
  return comparison;
}

}  // namespace lamella
