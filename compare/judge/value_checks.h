#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compare/judge/check_line.h"
#include "compare/judge/checked_model.h"

namespace lamella {

/// Pairs at which a model's values are looked at: cosines 1, 0.9, 0.5, 0.1, 1e-3, 1e-7 and 0 with
/// each other at azimuths between 0 and 180 degrees (not both 0), so w_i = w_o, the mirrored
/// direction and the plane of incidence are among them; 128 at random, of which every other has
/// cosines down to 1e-8, evenly in their logarithm. Each with both directions above, both below,
/// and on different sides; so w_o = -w_i is among them.
[[nodiscard]] std::vector<DirectionPair> checked_pairs(std::uint64_t seed);

/// Values are finite and not below 0, and 0 where light would have to pass unless the model
/// transmits.
void check_values(const CheckedModel& m, std::span<const DirectionPair> pairs, CheckLine& line);

/// f(w_i, w_o) = f(w_o, w_i) for reflection. Allowed: a relative difference of the model's stated
/// accuracy, see kReciprocity, or where that is exceeded eight times the measured noise of the two
/// values; of a stochastic model `deviations` standard errors.
void check_reciprocity(const CheckedModel& m, std::span<const DirectionPair> pairs,
                       double deviations, CheckLine& line);

/// One call with many pairs, on every instruction set, in both orders, and a call per pair give the
/// same; so does the sum of the lobes. Allowed: rounding of lanes, or eight times the noise.
void check_batches(const CheckedModel& m, std::span<const DirectionPair> pairs, CheckLine& line);

}  // namespace lamella
