#pragma once

#include <span>

#include "analytic/model/model.h"

namespace lamella {

/// Standard deviation of the rounding of f at (w_i, w_o), per channel, from 13 neighbours along a
/// line of 4e-5 in both directions' log cosines (or angles) and azimuths: the root mean square of
/// their sixth differences, divided by that of independent values of variance 1 (More and Wild
/// 2011, "Estimating computational noise", eq. 2.2). Wider than any rounding of directions in
/// single precision, narrower than any feature that a model has on purpose. An estimate from seven
/// differences: within a factor 2.
[[nodiscard]] Rgb value_noise(const Model& model, Direction wi, Direction wo);

/// Whether every lobe's value at these pairs is a number of single precision.
[[nodiscard]] bool is_single_precision(const Model& model, int lobes,
                                       std::span<const DirectionPair> pairs);

/// Relative rounding of one value: 16 units in the last place of its number type.
[[nodiscard]] inline double unit_rounding(bool single_precision) {
  return 16 * (single_precision ? 0x1p-23 : 0x1p-52);
}

}  // namespace lamella
