#pragma once

#include "phase/direction.h"
#include "phase/real.h"

namespace lamella {

/// Phase function of a white Lambertian sphere by the cosine of the deflection, in [-1, 1]:
/// p = 2 (sin theta - theta cos theta) / (3 pi^2) [1/sr], theta = acos(cosine); p(1) = 0.
/// d'Eon 2021, "An analytic BRDF for materials with spherical Lambertian scatterers", eq. 1.
/// Relative error below 1e-12: near theta = 0 the difference is expanded.
template <class Real>
[[nodiscard]] Real lambert_sphere_phase_of(Real cosine) {
  using std::sqrt;
  const Real s = sqrt(nonnegative((Real(1) - cosine) * (Real(1) + cosine)));
  const Real theta = angle_of(s, cosine), t2 = theta * theta;
  const Real near = theta * t2 * polynomial(t2, 1.0 / 3, -1.0 / 30, 1.0 / 840, -1.0 / 45360);
  const Real difference = select(theta < Real(0.1), near, s - theta * cosine);
  return Real(2 / (3 * kPi * kPi)) * difference;
}

}  // namespace lamella
