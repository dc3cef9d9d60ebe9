#pragma once

#include <string>
#include <vector>

#include "compare/judge/stack_comparison.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// Whether a name is that of a measured material: a MERL file (.binary) or a tensor file (.bsdf).
[[nodiscard]] bool is_measured_file(const std::string& name);

/// A reflection, and transmission where `info` says so, on cells, as a run of the solver: what the
/// projection leaves open, and its tolerance, stand for the bounds. It has the lobe "all" alone.
[[nodiscard]] Truth projected_truth(const Model& model, const ModelInfo& info, Direction wi,
                                    const CellGrid& cells, int channels);

/// What stands in the place of a stack's truth.
struct ModelTruth {
  const Model& model;
  ModelInfo info;
  std::string what;  ///< in words: "a measured material"
};

/// Closed forms against a measured material or a closed form, whose reflection, and transmission
/// where `info` says so, is the truth: of the request, directions and cells count. Its projection
/// onto cells is exact within what stands for the error bound, and it has no orders: lobes are
/// compared in "all" alone. `models` must outlive the result.
[[nodiscard]] StackComparison compare_with_model(const ModelTruth& truth,
                                                 const TruthRequest& request,
                                                 const std::vector<BoundModel>& models,
                                                 const RunMonitor& monitor);

}  // namespace lamella
