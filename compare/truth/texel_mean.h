#pragma once

#include <memory>

#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"
#include "volume/run/simulation.h"

namespace lamella {

/// Throws UsageError where the mean over texels of the request cannot be found: with explicit
/// geometry or density grids, or with the solver where it does not apply to all of them.
void check_texel_mean(const TruthRequest& request);

/// The plan that models every texel of the request.
[[nodiscard]] Plan texel_plan(const TruthRequest& request);

/// Walks through texels, and the seconds that they took, before a restart among them.
struct TexelWalks {
  std::unique_ptr<Simulation> batches;
  double seconds = 0;
  bool is_whole = true;  ///< whether nothing stopped it
  /// Of a rule with a target: the largest relative error that was reached, and the part of it that
  /// differences between texels make, which no number of walks takes away, by the last two rounds.
  double error = 0, of_texels = 0;
};

/// Walks through all texels of a request, `rule.walks` in all and as many in each: a simulation
/// whose batch b holds the walks of the texels b, b + kBatches, ..., to be reduced but not to go
/// on. The scatter of its batches has the walks' noise and the differences between texels; as these
/// are of strata, it is no less than the error of the mean. Where the rule has a clock, the number
/// of walks is what a texel in the middle reaches in its share of the time. Where it has a target
/// error, texels walk in rounds, each anew and with twice the walks of the one before, until a
/// round reaches it: the answer is that of its number of walks. A keeper of the monitor has the
/// batches of a direction once all their walks are done.
[[nodiscard]] TexelWalks walk_texels(const TruthRequest& request, const Plan& plan, Direction wi,
                                     Estimator estimator, StopRule rule, const RunMonitor& monitor);

/// The request for one texel. `share`: of the request's time that it has.
[[nodiscard]] TruthRequest request_of_texel(const TruthRequest& request, std::size_t texel,
                                            double share);
/// The texel's own plan, with channels, sides and folding as all texels need them.
[[nodiscard]] Plan plan_of_texel(const TruthRequest& request, std::size_t texel, const Plan& all);

}  // namespace lamella
