#pragma once

#include <span>
#include <vector>

#include "compare/nearest/fit_target.h"
#include "compare/nearest/nearest_models.h"

namespace lamella {

/// Incident directions that nothing was fitted to: half way between every two neighbours
/// in theta of those that they were, and, on either side of the horizon, half way from the last of
/// them to grazing where there is but one.
[[nodiscard]] std::vector<Direction> held_out_directions(std::vector<Direction> fitted);

/// Root of the mean over incident directions of sum (m - t)^2 / sum t^2, the noise taken off both:
/// the target's, and that of the means m with these standard errors (none: they have no noise).
[[nodiscard]] double held_out_error(const FitTarget& target, std::span<const double> means,
                                    std::span<const double> errors = {});

/// Judges every fit of a closed form on the truths of other directions than its own: HeldOut of
/// `nearest`. Where there is no light along them, nothing.
void judge_held_out(NearestModels& nearest, const TargetTruths& others);

}  // namespace lamella
