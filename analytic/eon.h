#pragma once

#include <array>

#include "analytic/model.h"

namespace lamella {

// Portsmouth, Kutz and Hill 2025, "EON: A practical energy-preserving rough diffuse BRDF"; equation
// numbers are theirs. rho: albedo of the facets, r: roughness in [0, 1]. s / t is fujii_term of
// analytic/oren_nayar.h. All reciprocal.

/// Fujii's energy-conserving model: f = rho / pi (A + B s / t), A = 1 / (1 + (1/2 - 2 / (3 pi)) r),
/// B = r A (eqs. 10, 11).
[[nodiscard]] ModelInfo fon_model();

/// FON and the energy it loses (eq. 16). Lobes `ss`, FON itself, and `ms`:
///   rho^2 / pi <E> / (1 - rho (1 - <E>)) (1 - E(mu_i)) (1 - E(mu_o)) / (1 - <E>)
/// with E, <E> FON's directional and average albedo at rho = 1 (eq. 19). Directional albedo in
/// closed form, 1 within 1e-15 at rho = 1. Sampler: see EonSampler.
[[nodiscard]] ModelInfo eon_model();

/// EON with the fit of eq. 14 for E, clamped at 1: white albedo 0.9994 to 1.0002.
[[nodiscard]] ModelInfo eon_approx_model();

/// Directional albedo of FON at rho = 1 (eqs. 12, 13); mu in [0, 1].
[[nodiscard]] double fon_albedo(double mu, double roughness);
/// Its fit, eq. 14: absolute error below 6.1e-4 r; above 1 by up to 3.6e-4.
[[nodiscard]] double fon_albedo_fit(double mu, double roughness);
/// Average albedo of FON at rho = 1 (eq. 15).
[[nodiscard]] double fon_average_albedo(double roughness);

/// EON's sampler of w_i given w_o, independent of rho: a clipped linearly transformed cosine and
/// the uniform hemisphere, one of them drawn (one-sample multiple importance sampling); its density
/// is their exact mixture. Section 3.1; the coefficients of the transformation
/// M = [[a, 0, b], [0, c, 0], [d, 0, 1]], in the frame in which w_o = (sin, 0, mu), are the fit
/// of its listing 2.
class EonSampler {
 public:
  /// mu: cosine of w_o in [0, 1].
  EonSampler(double mu, double roughness);

  /// Probability of the uniform hemisphere.
  [[nodiscard]] double uniform_probability() const { return uniform_; }
  /// a, b, c, d.
  [[nodiscard]] const std::array<double, 4>& coefficients() const { return m_; }
  /// A direction in the frame of w_o from three uniforms in (0, 1).
  [[nodiscard]] Direction sample(double u1, double u2, double u3) const;
  /// Density [1/sr] of a direction in the frame of w_o.
  [[nodiscard]] double pdf(Direction wi) const;

 private:
  [[nodiscard]] double clipped_pdf(Direction wi) const;

  std::array<double, 4> m_;
  double uniform_;
  double area_;  // of the clipped unit disc, over pi: (1 + 1 / sqrt(1 + d^2)) / 2
};

}  // namespace lamella
