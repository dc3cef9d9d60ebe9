#pragma once

#include "volume/run/simulation.h"

namespace lamella {

/// p-value of the hypothesis that the walks' own order 1 has the closed form as its mean: by the
/// largest deviation, in standard errors over the batches (Student's t, Bonferroni's bound), of
/// patches of cells, of the energies of both sides, and of the light that meets nothing. Quantities
/// of less than 100 effective events are left out. The walks' single precision is allowed 1e-4 of
/// each quantity, so the check is for faults, not for rounding. 1 where walks give order 1.
[[nodiscard]] double first_check(const Simulation& simulation);

/// Below this a result is at fault (compare/truth/ground_truth.h).
inline constexpr double kImplausibleFirst = 1e-9;

}  // namespace lamella
