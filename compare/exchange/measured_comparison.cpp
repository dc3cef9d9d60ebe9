#include "compare/exchange/measured_comparison.h"

#include <algorithm>
#include <cmath>

#include "compare/exchange/exported.h"
#include "compare/judge/projection.h"

namespace lamella {

Truth projected_truth(const Model& model, const ModelInfo& info, Direction wi,
                      const CellGrid& cells, int channels) {
  Truth truth;
  RunResult& run = truth.run;
  run.incident = wi;
  run.estimator = Estimator::deterministic;
  run.grid = cells;
  run.grid.folded = false;
  run.channels = channels;
  const auto n = static_cast<std::size_t>(run.grid.cells());
  const double solid_angle = run.grid.projected_solid_angle();
  DeterministicAccuracy accuracy;
  accuracy.reached = true;
  for (const bool reflected : {true, false}) {
    if (!reflected && !info.transmits) continue;
    const bool up = (wi.z >= 0) == reflected;
    const ProjectedLobes found = project(model, info, wi, run.grid, up, channels);
    SideResult& side = reflected ? run.reflected : run.transmitted;
    LobeEstimate& lobe = side.lobes[Order::all];
    lobe.value = found.lobes[Order::all];
    lobe.standard_error = found.errors[Order::all];
    for (std::size_t k = 0; k < lobe.value.size(); ++k) {
      lobe.standard_error[k] =
          std::max(lobe.standard_error[k], kProjectionTolerance * std::abs(lobe.value[k]));
      side.total[k / n].value += lobe.value[k] * solid_angle;
      side.total[k / n].standard_error += lobe.standard_error[k] * solid_angle;
      if (lobe.value[k] > 0)
        accuracy.error = std::max(accuracy.error, lobe.standard_error[k] / lobe.value[k]);
    }
  }
  for (int c = 0; c < channels; ++c) {
    const Estimate &up = run.reflected.total[c], &down = run.transmitted.total[c];
    run.absorbed[c] = {1 - up.value - down.value, up.standard_error + down.standard_error};
  }
  run.accuracy = accuracy;
  return truth;
}

bool is_measured_file(const std::string& name) {
  return name.ends_with(".binary") || name.ends_with(".bsdf");
}

StackComparison compare_with_model(const ModelTruth& truth, const TruthRequest& request,
                                   const std::vector<BoundModel>& models,
                                   const RunMonitor& monitor) {
  Plan plan;
  plan.channels = 3;
  plan.folded = false;
  plan.transmits = truth.info.transmits;
  std::vector<Truth> truths;
  for (const Direction wi : request.directions) {
    if (monitor.is_stopped() && !truths.empty()) break;
    truths.push_back(projected_truth(truth.model, truth.info, wi, request.cells, 3));
  }
  StackComparison comparison = compare_truths(
      truths, plan, {Estimator::deterministic, truth.what + " on cells", nullptr}, models);
  comparison.interrupted = monitor.is_stopped();
  return comparison;
}

}  // namespace lamella
