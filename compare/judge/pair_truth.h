#pragma once

#include <cstdint>
#include <vector>

#include "analytic/model/model.h"
#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"
#include "compare/truth/estimator_choice.h"

namespace lamella {

/// f [1/sr] of a stack at pairs of directions.
struct PairTruth {
  EstimatorChoice choice;
  std::vector<Rgb> f;
  /// Per pair: the standard error of walks, with f of what cut walks held were it spread like
  /// Lambert's over one side; or the solver's bound.
  std::vector<Rgb> error;
  std::uint64_t fewest_walks = 0;  ///< of any incident direction; 0 from the solver

  /// Whether the solver found it.
  [[nodiscard]] bool is_solved() const { return choice.estimator == Estimator::deterministic; }
};

/// Finds it by the request's estimator, next-event walks or the solver; the request's own
/// directions and cells mean nothing. Where nothing is asked of the effort the clock ends walks; a
/// time that is asked for ends them, too.
/// Both cosines of a pair at 0 are refused (std::invalid_argument), like light from below where the
/// stack is closed there. Throws what choose_estimator throws, and NoAnswerError where the solver
/// was asked for and its values are none.
[[nodiscard]] PairTruth truth_of_pairs(const TruthRequest& request,
                                       const std::vector<DirectionPair>& pairs,
                                       const RunMonitor& monitor);

}  // namespace lamella
