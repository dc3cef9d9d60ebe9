#pragma once

#include <atomic>
#include <span>
#include <vector>

#include "volume/plan/plan.h"
#include "volume/result/run_result.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// What of a tolerance for cells goes to the solution; the quadratures over cells have the rest.
inline constexpr double kSolverShare = 0.5;

/// The lobes on cells and the ledger of a solved stack, one result per incident direction, in the
/// form that walks give them; error bounds stand in the place of standard errors.
///
/// Orders 2 and up are integrated exactly in phi, mode by mode, and by Gauss-Legendre panels in mu,
/// refined until what they leave is below `tolerance` of the mean over the azimuth (or half of the
/// solution's error, where that is more); order 1 is the closed form, by adaptive quadrature over
/// each cell. The bound of a cell adds what both leave to the solution's own error; the bound of an
/// energy adds how far the sum over its cells is from the energy that the solver found on its
/// nodes. `plan` decides channels and folding. Light that is lost to the depth of a half space
/// counts as transmitted. mu = 0 is the limit from above.
///
/// accuracy.error becomes the largest bound of a cell of the lobe "all", relative to the mean over
/// the azimuth at its mu, and accuracy.reached says whether that is within `tolerance`.
/// `stop`, where there is one, ends the refinement once it is true; bounds say what that leaves.
/// `report`, where there is one, is told after each round of points and each side of a direction.
/// Runs in the calling thread's task arena; `seconds` holds each result's share of the time.
[[nodiscard]] std::vector<RunResult> deterministic_runs(const DeterministicSolution& solution,
                                                        const Plan& plan,
                                                        std::span<const Direction> incident,
                                                        CellGrid grid, double tolerance,
                                                        const std::atomic<bool>* stop = nullptr,
                                                        const SolverReport& report = {});

}  // namespace lamella
