#pragma once

#include <optional>

#include "phase/math/direction.h"
#include "phase/math/real.h"

namespace lamella {

/// A pair of directions above the surface as isotropic models see it: cosines and sines with the
/// normal, and the azimuth phi of w_o relative to w_i (phi = 0: same side, back scattering).
/// mu = 0 stands for its limit from above. At normal incidence phi = 0.
template <class Real>
struct Angles {
  Real mu_i, mu_o;    ///< in (0, 1]
  Real sin_i, sin_o;  ///< in [0, 1]
  Real cos_phi;       ///< in [-1, 1]
  Real sin_phi;       ///< of |phi|, in [0, 1]
  Real sines_cos;     ///< sin_i sin_o cos_phi, without the detour over phi

  /// |phi| in [0, pi], to rounding at its ends too.
  [[nodiscard]] Real phi() const { return angle_of(sin_phi, cos_phi); }
};
using ReflectionAngles = Angles<double>;

/// The angles of two directions with z >= 0.
template <class Real>
[[nodiscard]] Angles<Real> angles_above(Vec3<Real> wi, Vec3<Real> wo) {
  using std::sqrt;
  const Real one = Real(1), grazing = Real(kGrazingLimit);
  const Real xy = multiply_add(wi.x, wo.x, wi.y * wo.y);
  const Real si = min(one, sqrt(multiply_add(wi.x, wi.x, wi.y * wi.y)));
  const Real so = min(one, sqrt(multiply_add(wo.x, wo.x, wo.y * wo.y)));
  const Real product = si * so, zero = Real(0);
  const Real cross = multiply_add(wi.x, wo.y, -(wi.y * wo.x));
  const auto inclined = product > zero;
  return {.mu_i = min(one, max(wi.z, grazing)),
          .mu_o = min(one, max(wo.z, grazing)),
          .sin_i = si,
          .sin_o = so,
          .cos_phi = select(inclined, max(-one, min(one, xy / product)), one),
          .sin_phi = select(inclined, min(one, max(cross, -cross) / product), zero),
          .sines_cos = xy};
}

/// The angles of a reflection from above, or nothing if one of the directions lies below.
[[nodiscard]] inline std::optional<ReflectionAngles> reflection_angles(Direction wi, Direction wo) {
  if (wi.z < 0 || wo.z < 0) return std::nullopt;
  return angles_above(wi, wo);
}

}  // namespace lamella
