#pragma once

#include <numbers>

#include "phase/math/vec3.h"

namespace lamella {

inline constexpr double kPi = std::numbers::pi;

/// Stands for the limit mu -> 0 from above. Its square is still a normal number, so that ratios
/// such as sigma(w) / mu keep their limit in double precision.
inline constexpr double kGrazingLimit = 1e-150;

/// A direction by its cosine mu with the normal, in [-1, 1], and azimuth phi in radians.
[[nodiscard]] Direction direction_from_mu_phi(double mu, double phi);

/// A direction by polar angle and azimuth in degrees. theta in [0, 180]; 90 is mu = 0 exactly and
/// multiples of 90 degrees of phi fall exactly on the axes.
[[nodiscard]] Direction direction_from_degrees(double theta, double phi);

/// w with |mu| below kGrazingLimit replaced by the limit on its side (mu = 0: from above).
[[nodiscard]] Direction with_grazing_limit(Direction w);

/// Azimuth of w in [0, 2 pi).
[[nodiscard]] double azimuth(Direction w);

}  // namespace lamella
