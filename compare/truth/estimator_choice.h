#pragma once

#include <memory>
#include <string>

#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// Which estimator finds the truth of a stack, and why.
struct EstimatorChoice {
  Estimator estimator = Estimator::analog;
  std::string reason;
  /// The solved stack, where the estimator is deterministic.
  std::shared_ptr<const DeterministicSolution> solution;
};

/// The estimator asked for, or what `auto` stands for: a walk where an option was given that only
/// walks have a use for, or where the solver does not apply; else the deterministic solver if it
/// reaches the tolerance with few enough nodes and modes (which are the same on any machine) to be
/// done in seconds, or is interrupted on the way with what it has; else a walk. `of_walks`: the
/// estimator of walks where none is named. Throws UsageError where the solver is asked for and does
/// not apply.
[[nodiscard]] EstimatorChoice choose_estimator(const TruthRequest& request, Estimator of_walks,
                                               const StopFlag* stop);

/// A finer solution than the choice's, where cells miss a tolerance that the solver's probes met:
/// pairs of directions and the quadratures over cells have errors of their own.
[[nodiscard]] std::shared_ptr<const DeterministicSolution> refined(const TruthRequest& request,
                                                                   const StopFlag* stop);

/// Why `auto` took the solver: "the solver reaches 6.9e-08 with 24 nodes and 60 modes".
[[nodiscard]] std::string reached_by(const DeterministicSolution& solution);

/// For a table: "deterministic estimator (auto: ...), tolerance 1e-6" or "analog estimator, seed
/// 1".
[[nodiscard]] std::string estimator_text(const EstimatorChoice& choice,
                                         const TruthRequest& request);

/// Throws UsageError where the deterministic estimator is asked for and does not apply: cheap,
/// before any work.
void check_estimator(const TruthRequest& request);

}  // namespace lamella
