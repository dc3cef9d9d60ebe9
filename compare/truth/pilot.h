#pragma once

#include <string>

#include "compare/request/truth_request.h"

namespace lamella {

/// The result of short runs of both estimators of walks on a stack.
struct Pilot {
  Estimator best = Estimator::analog;
  double advantage = 1;  ///< time x variance of the other one over that of the best
  /// Where next-event was not tried: the estimated seconds of its first walks.
  double first_seconds = 0;
};

/// Runs both for a twentieth of a second each, or until they have 4096 walks, for a second at most,
/// and compares seconds times variance: of the lobes' energies where a target error ends the run,
/// else of all orders' cells. Next-event is not tried where its first walks would take longer than
/// a second, by the price of its collisions on walks of a few orders. The answer may differ between
/// runs where both are about equally good; files record which one was taken. `plan`: of the
/// request's stack.
[[nodiscard]] Pilot pilot(const TruthRequest& request, const Plan& plan, Direction incident);

/// "pilot: next-event has 5.3 times less time x variance".
[[nodiscard]] std::string to_text(const Pilot& pilot);

}  // namespace lamella
