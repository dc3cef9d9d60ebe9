#include "analytic/half_space/three_term_constants.h"

#include <fmt/format.h>

#include <algorithm>

#include "analytic/half_space/lambert_sphere_formula.h"
#include "analytic/half_space/lambert_sphere_models.h"
#include "analytic/half_space/three_term.h"

namespace lamella {
namespace {

// Of l and n = l^2 + 45 m / 64.
double m_of(double l, double n) { return (n - l * l) * 64 / 45; }

}  // namespace

LambertSphereConstants exact_lambert_sphere_constants(double albedo) {
  // l and n are quotients of two terms that vanish with the albedo.
  const ThreeTermHalfSpace half_space(lambert_sphere_phase_terms(std::max(albedo, 1e-7)));
  LambertSphereConstants found{half_space.mode_0_constants(), half_space.l(),
                               m_of(half_space.l(), half_space.n())};
  for (double& constant : found.mode_0) constant /= 2;  // eq. 36 has half of them
  return found;
}

LambertSphereConstants fitted_lambert_sphere_constants(double albedo) {
  const AnalyticLambertSphere::Channel fit = lambert_sphere_formula(Rgb(albedo)).channels[0];
  return {{fit.a, fit.b, fit.c, fit.d, fit.e, fit.f}, fit.l, m_of(fit.l, fit.n)};
}

std::vector<PartInfo> lambert_sphere_constant_parts(
    const std::string& how, LambertSphereConstants (*constants)(double albedo)) {
  std::vector<PartInfo> parts;
  for (std::size_t k = 0; k < 6; ++k)
    parts.push_back(part_of_albedo(
        fmt::format("constant_{}", "abcdef"[k]),
        fmt::format("{} of azimuthal mode 0, eq. 36, {}; of no direction", "ABCDEF"[k], how),
        [=](double c, double) { return constants(c).mode_0[k]; }));
  for (const bool is_l : {true, false})
    parts.push_back(part_of_albedo(
        is_l ? "constant_l" : "constant_m",
        fmt::format("{} of azimuthal mode 1, eq. 27, {}; of no direction", is_l ? 'l' : 'm', how),
        [=](double c, double) { return is_l ? constants(c).l : constants(c).m; }));
  return parts;
}

}  // namespace lamella
