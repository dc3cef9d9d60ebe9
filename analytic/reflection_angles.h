#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "phase/direction.h"

namespace lamella {

/// A pair of directions above the surface as isotropic models see it: cosines and sines with the
/// normal, and the azimuth phi of w_o relative to w_i (phi = 0: same side, back scattering).
/// mu = 0 stands for its limit from above. At normal incidence phi = 0.
struct ReflectionAngles {
  double mu_i, mu_o;    ///< in (0, 1]
  double sin_i, sin_o;  ///< in [0, 1]
  double cos_phi;       ///< in [-1, 1]
  double sines_cos;     ///< sin_i sin_o cos_phi, without the detour over phi

  /// |phi| in [0, pi].
  [[nodiscard]] double phi() const { return std::acos(cos_phi); }
};

/// The angles of a reflection from above, or nothing if one of the directions lies below.
[[nodiscard]] inline std::optional<ReflectionAngles> reflection_angles(Direction wi, Direction wo) {
  if (wi.z < 0 || wo.z < 0) return std::nullopt;
  const double xy = wi.x * wo.x + wi.y * wo.y;
  const double si = std::min(1.0, std::sqrt(wi.x * wi.x + wi.y * wi.y));
  const double so = std::min(1.0, std::sqrt(wo.x * wo.x + wo.y * wo.y));
  const double product = si * so;
  return ReflectionAngles{.mu_i = std::max(wi.z, kGrazingLimit),
                          .mu_o = std::max(wo.z, kGrazingLimit),
                          .sin_i = si,
                          .sin_o = so,
                          .cos_phi = product > 0 ? std::clamp(xy / product, -1.0, 1.0) : 1.0,
                          .sines_cos = xy};
}

}  // namespace lamella
