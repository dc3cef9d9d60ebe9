#pragma once

#include <vector>

#include "compare/nearest/nearest_models.h"

namespace lamella {

/// Incident directions that closed forms were not fitted to: half way between every two neighbours
/// in theta of those that they were, and, on either side of the horizon, half way from the last of
/// them to grazing where there is but one.
[[nodiscard]] std::vector<Direction> held_out_directions(std::vector<Direction> fitted);

/// Judges every fit on the truths of other directions than its own: HeldOut of `nearest`. Where
/// there is no light along them, nothing.
void judge_held_out(NearestModels& nearest, const TargetTruths& others);

}  // namespace lamella
