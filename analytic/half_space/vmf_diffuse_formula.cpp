#include "analytic/half_space/vmf_diffuse_formula.h"

#include <limits>

#include "phase/medium/vmf.h"

namespace lamella {
namespace {

struct Powers {
  double r, r2, r25, r3, r4;

  explicit Powers(double x) : r(x), r2(x * x), r25(r2 * std::sqrt(x)), r3(r2 * x), r4(r2 * r2) {}
};

VmfModeFormula formula_of(const Powers& p) {
  const auto [r, r2, r25, r3, r4] = p;
  return {.sigma = VmfSigmaFit(vmf_alpha(r)),
          .c10 = {1 + (0.84 * r4 - 0.1 * r) / (9 * r3 + 1),
                  (-9.47 * r3 + 20.4 * r2 + 0.0173 * r) / (7.46 * r + 1),
                  (2.37 * r2 - 0.927 * r) / (r2 + 1.24),
                  (-1.54 * r2 - 0.11 * r) / (7.1 * r2 - 1.05 * r + 1)},
          .c11 = {(0.54 * r - 0.182 * r3) / (1.32 * r2 + 1),
                  (-0.375 * r3 + 0.62 * r2 - 0.097 * r) / (0.4 * r3 + 1),
                  -0.681 * r2 + 0.862 * r + 0.283},
          .c12 = {(5.1 * r2 + 2.25 * r) / (32.4 * r2 + 9.8 * r + 1),
                  (6 * r3 - 4.32 * r) / (287 * r3 + 9.7 * r + 1)},
          .c20 = {(0.226 * r2 + 0.00056 * r) / (7.07 * r2 + 1),
                  (-12.04 * r3 + 4.57 * r2 - 0.268 * r) / (36.7 * r3 + 1),
                  (-0.97 * r3 + 2.52 * r2 + 0.418 * r) / (10 * r2 + 1),
                  (2.65 * r3 - 2.25 * r2 + 0.068 * r) / (21.4 * r3 + 1),
                  (0.05 * r - 4.22 * r3) / (43.1 * r3 + 17.6 * r2 + 1)},
          .c21 = {(-0.027 * r3 - 0.049 * r) / (3.36 * r2 + 1),
                  (-8.332 * r25 + 6.073 * r3 + 2.77 * r2) / (50 * r4 + 1),
                  (-0.295 * r3 - 0.431 * r2) / (23.9 * r3 + 1)},
          .c30 = {(0.262 * r4 - 0.083 * r3) / (38.6 * r4 - 1.9 * r2 + 1),
                  (4.95 * r25 - 2.44 * r3 - 0.627 * r2) / (31.5 * r4 + 1),
                  (0.31 * r25 + 1.4 * r3 + 0.33 * r2) / (20 * r3 + 1),
                  (1.77 * r25 - 4.06 * r3 - 0.74 * r2) / (215 * r4 * r + 1),
                  -1.026 * r3 / (13.2 * r3 + 5.81 * r2 + 1)},
          .c31 = {(0.028 * r2 - 0.0132 * r3) / (-3.315 * r4 + 7.46 * r2 + 1),
                  (0.162 * r25 + 0.302 * r3 - 0.134 * r2) / (57.5 * r4 * std::sqrt(r) + 1),
                  (0.5 * r25 - 0.207 * r3 - 0.119 * r2) / (18.7 * r3 + 1)}};
}

/// The factor of f_m that depends on albedo and roughness alone, and its offset.
double higher_order_scale(double c, double r) {
  const double s = std::sqrt(1 - c);
  const double ck = (1 - 0.453 * (1 - c) - 0.544 * s) / (1.429 * s + 1);
  const double ca = c * std::pow(1.169 * s + 1, -std::atan((r - 0.265) * r + 0.0225) * std::erf(s));
  return 0.384 * ck * (ca - 0.342) * ca;
}
double higher_order_offset(double r) { return std::abs(std::tanh(r) - 0.09); }

}  // namespace

VmfModeFormula vmf_mode_formula(double roughness) { return formula_of(Powers(roughness)); }

VmfDiffuseFormula vmf_diffuse_formula(Rgb albedo, double r, bool printed) {
  const auto channel = [&](double c) {
    return VmfDiffuseFormula::Channel{c, c * c, c * c * c, higher_order_scale(c, r)};
  };
  return {.modes = vmf_mode_formula(r),
          .fold = printed ? 1.0 : 2.0,
          .floor = printed ? -std::numeric_limits<double>::infinity() : 0.0,
          .offset = higher_order_offset(r),
          .channels = {channel(albedo.r), channel(albedo.g), channel(albedo.b)}};
}

}  // namespace lamella
