#pragma once

#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"
#include "volume/run/simulation.h"

namespace lamella {

/// Throws UsageError where the mean over texels of the request cannot be walked: with the solver,
/// --target-error, explicit geometry or density grids.
void check_texel_mean(const TruthRequest& request);

/// The plan that models every texel of the request.
[[nodiscard]] Plan texel_plan(const TruthRequest& request);

/// Walks through all texels of a request, `rule.walks` in all and as many in each: a simulation
/// whose batch b holds the walks of the texels b, b + kBatches, ..., to be reduced but not to go
/// on. The scatter of its batches has the walks' noise and the differences between texels; as these
/// are of strata, it is no less than the error of the mean. Where the rule has a clock, the number
/// of walks is what a texel in the middle reaches in its share of the time.
[[nodiscard]] std::unique_ptr<Simulation> walk_texels(const TruthRequest& request, const Plan& plan,
                                                      Direction wi, Estimator estimator,
                                                      StopRule rule, const RunMonitor& monitor);

}  // namespace lamella
