#pragma once

#include <functional>
#include <string>
#include <vector>

#include "compare/judge/projection.h"
#include "compare/judge/stack_comparison.h"
#include "compare/report/lobe_set.h"
#include "compare/truth/ground_truth.h"

namespace lamella {

/// What closed forms are fitted to, and judged by afterwards: the truth of each incident direction,
/// wherever it is from.
struct TargetTruths {
  TruthRequest request;  ///< of what is no stack: its name, directions and cells
  Plan plan;             ///< channels and sides
  EstimatorChoice choice;
  std::vector<Truth> truths;
  bool interrupted = false;  ///< whether directions or walks are missing
};

/// The truth of a stack.
[[nodiscard]] TargetTruths truths_of(GroundTruth& truth);

/// A closed form or a measured material on the request's cells, in its directions.
[[nodiscard]] TargetTruths truths_of(const Model& model, const ModelInfo& info, int channels,
                                     TruthRequest request, const RunMonitor& monitor);

/// Lobes from a file, `name`d like it, with their own directions and cells.
[[nodiscard]] TargetTruths truths_of(const LobeSet& lobes, const std::string& name);

/// Closed forms against the target. Lobes from a file do not have their walks: kErrorsAsBound
/// standard errors then stand for a bound.
[[nodiscard]] StackComparison compare_with(const TargetTruths& target,
                                           const std::vector<BoundModel>& models);
inline constexpr double kErrorsAsBound = 4;

/// The same of one that is there on cells: `lobes` gives those of the k-th incident direction on
/// one side, on the truth's own cells.
using LobesOnCells = std::function<ProjectedLobes(std::size_t k, bool reflected)>;
[[nodiscard]] StackComparison compare_with(const TargetTruths& target, const BoundModel& model,
                                           const LobesOnCells& lobes);

}  // namespace lamella
