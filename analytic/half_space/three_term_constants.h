#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "analytic/half_space/three_term.h"
#include "analytic/model/model.h"

namespace lamella {

/// The constants of a half space with a three-term phase function as d'Eon 2021 has them,
/// dimensionless: A to F of mode 0 (eq. 36), l and m of mode 1 (eq. 27, where 1 + l (x + y) + n x y
/// has n = l^2 + 45 m / 64).
struct ThreeTermConstants {
  std::array<double, 6> mode_0;  ///< A, B, C, D, E, F
  double l, m;
};

/// Of the exact solution. Its w[1] is not 0.
[[nodiscard]] ThreeTermConstants three_term_constants(const ThreeTermHalfSpace& half_space);
/// m by l and n.
[[nodiscard]] double three_term_m(double l, double n);

/// `constant_a` to `constant_f`, `constant_l` and `constant_m`, as `lamella eval` prints them.
/// how: "exact" or "fitted".
[[nodiscard]] std::vector<PartInfo> constant_parts(
    const std::string& how, const std::function<ThreeTermConstants(double albedo)>& constants);

}  // namespace lamella
