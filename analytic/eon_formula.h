#pragma once

#include <cmath>

#include "phase/direction.h"

namespace lamella {

/// fon_loss(1): 1/2 - 2 / (3 pi).
inline constexpr double kFonNormalLoss = 0.5 - 2 / (3 * kPi);

/// What FON loses of the light from mu in [0, 1], per unit of A r:
///   (1 - E(mu)) / (A r) = 1/2 - 2 / (3 pi) - G_F(mu) / pi.
/// EON's eqs. 8 and 13 are 0/0 at mu = 0 and lose, near it, all digits of the difference. With
/// s = sqrt(1 - mu^2), 1 - s = mu^2 / (1 + s) and theta = pi/2 - asin(mu) it is
///   ((pi/2 - 2/3) mu^2 / (1 + s) + s asin(mu) + mu s^2 - 2/3 mu s (1 + s + s^2) / (1 + s)) / pi,
/// every term of which vanishes like mu. Relative error below 5 epsilon of Real for all mu, 0
/// included. Portsmouth, Kutz and Hill 2025, "EON", eqs. 8, 12, 13.
template <class Real>
[[nodiscard]] Real fon_loss(Real mu) {
  using std::asin;
  using std::sqrt;
  const Real s = sqrt((Real(1) - mu) * (Real(1) + mu));
  const Real q = mu / (Real(1) + s);
  const Real third = Real(2.0 / 3);
  return (Real(kPi / 2 - 2.0 / 3) * mu * q + s * asin(mu) + mu * s * s -
          third * s * (Real(1) + s + s * s) * q) *
         Real(1 / kPi);
}

}  // namespace lamella
