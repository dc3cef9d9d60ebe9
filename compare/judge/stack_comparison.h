#pragma once

#include <string>
#include <vector>

#include "compare/judge/comparison.h"
#include "compare/judge/side_by_side.h"
#include "compare/request/model_request.h"
#include "compare/truth/ground_truth.h"

namespace lamella {

/// One closed form on every lobe of a stack that it stands for.
struct JudgedModel {
  const BoundModel* bound = nullptr;
  std::string name;        ///< of its files: distinct among the models of a comparison
  std::string label;       ///< the same for people (distinct_labels)
  double nanoseconds = 0;  ///< per evaluation of one pair; 0: of what has lobes on cells alone
  std::vector<LobeComparison> lobes{};
};

/// Closed forms against the truth of a stack.
struct StackComparison {
  EstimatorChoice choice;  ///< of the truth's estimator
  int channels = 1;
  std::vector<RunResult> runs;                        ///< per incident direction
  std::vector<RunResult> map_errors{};                ///< Truth::map_error of each, if they have it
  std::vector<TruthRequest::SolverEnd> texel_ends{};  ///< GroundTruth::texel_ends
  std::vector<JudgedModel> models;
  std::vector<SideBySide> beside;  ///< of explicit geometry: the media that can stand for it
  bool interrupted = false;        ///< whether directions or walks are missing
};

/// Finds the truth of each incident direction and judges the models by it, verdicts included.
/// `models` must outlive the result.
[[nodiscard]] StackComparison compare_stack(GroundTruth& truth,
                                            const std::vector<BoundModel>& models);

/// The same of truths that are there already. `plan`: channels and sides of them.
[[nodiscard]] StackComparison compare_truths(const std::vector<Truth>& truths, const Plan& plan,
                                             const EstimatorChoice& choice,
                                             const std::vector<BoundModel>& models);

/// The largest relative RMSE over all orders that is certain, noise and missing light left out; inf
/// where a model has light and the truth has none, if the verdict is that they differ.
[[nodiscard]] double worst_relative_rmse(const StackComparison& comparison);

}  // namespace lamella
