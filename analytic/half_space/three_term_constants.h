#pragma once

#include <array>
#include <string>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// The constants of d'Eon 2021 for one albedo, dimensionless: A to F of mode 0 (eq. 36), l and m of
/// mode 1 (eq. 27, where 1 + l (x + y) + n x y has n = l^2 + 45 m / 64).
struct LambertSphereConstants {
  std::array<double, 6> mode_0;  ///< A, B, C, D, E, F
  double l, m;
};

/// Those of the exact three-term half space. albedo in [0, 1]; at 0 the limit, within 1e-6.
[[nodiscard]] LambertSphereConstants exact_lambert_sphere_constants(double albedo);
/// Those of the analytic form: A and E exact, the others as the paper fits them.
[[nodiscard]] LambertSphereConstants fitted_lambert_sphere_constants(double albedo);

/// `constant_a` to `constant_f`, `constant_l` and `constant_m`, as `lamella eval` prints them.
/// how: "exact" or "fitted".
[[nodiscard]] std::vector<PartInfo> lambert_sphere_constant_parts(
    const std::string& how, LambertSphereConstants (*constants)(double albedo));

}  // namespace lamella
