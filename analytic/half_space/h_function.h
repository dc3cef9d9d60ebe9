#pragma once

#include <array>
#include <vector>

#include "phase/math/real.h"

namespace lamella {

/// Chandrasekhar's H function of a half space, for mu in [0, 1]: the solution of
///   1 / H(mu) = 1 - mu * integral over x in (0, 1) of Psi(x) H(x) / (mu + x)
/// without zeros for Re mu > 0, for an even characteristic function
///   Psi(x) = sum over k of psi[k] x^(2k).
/// With K(t) = 1 - 2 * integral over x in (0, 1) of Psi(x) / (1 + x^2 t^2),
///   log H(mu) = -mu / pi * integral over t in (0, infinity) of log K(t) / (1 + mu^2 t^2).
/// In x = log t the integrand is analytic in the strip |Im x| < pi / 2 and decays exponentially, so
/// the trapezoidal rule with step h errs by exp(-pi^2 / h); h = 1/4 leaves rounding only.
/// Fock 1944; d'Eon 2021, "An analytic BRDF for materials with spherical Lambertian scatterers",
/// eqs. 20, 22, 23.
class HFunction {
 public:
  /// psi: coefficients of Psi. k0 = K(0) >= 0, the same as 1 - 2 sum psi[k] / (2k + 1), given apart
  /// because that difference cancels where scattering is conservative (k0 = 0).
  HFunction(std::vector<double> psi, double k0);

  /// H(mu) from a Chebyshev series in mu^(1/4), in which H is smooth (near 0 it goes like mu log
  /// mu). Relative error below 2e-12.
  [[nodiscard]] double operator()(double mu) const;

  /// H(mu) by the integral itself: relative error below 1e-13. For tests and for the series.
  [[nodiscard]] double by_quadrature(double mu) const;

  /// Integral over mu in (0, 1) of mu^k H(mu): relative error below 1e-12.
  [[nodiscard]] double moment(int k) const;

  /// Psi(x).
  [[nodiscard]] double characteristic(double x) const;

 private:
  static constexpr int kTerms = 64;

  [[nodiscard]] double log_k(double t) const;

  std::vector<double> psi_;
  double k0_;
  std::vector<double> t_, log_k_;  // nodes of the trapezoidal rule
  std::array<double, kTerms> series_{};
};

/// The H function of isotropic scattering with albedo c in [0, 1]: Psi = c / 2, K(0) = 1 - c.
[[nodiscard]] HFunction isotropic_h(double albedo);

/// Rational approximation of the isotropic H: (1 + 2 mu) / (1 + 2 mu sqrt(1 - c)).
/// Relative error below 0.041.
/// Hapke 1981, "Bidirectional reflectance spectroscopy: 1. Theory".
[[nodiscard]] double isotropic_h_hapke_1981(double mu, double albedo);
/// This approximation less 1, without the cancellation at small mu, over any number type; root:
/// sqrt(1 - c).
template <class Real>
[[nodiscard]] Real hapke_1981_rise(Real mu, double root) {
  return Real(2 * (1 - root)) * mu / multiply_add(Real(2 * root), mu, Real(1));
}

/// Approximation of the isotropic H with its logarithm: with s = sqrt(1 - c), r = (1 - s) / (1 +
/// s),
///   1 / H = 1 - c mu (r + (1/2 - r mu) log((1 + mu) / mu)).
/// Relative error below 0.0097.
/// Hapke 2002, "Bidirectional reflectance spectroscopy: 5".
[[nodiscard]] double isotropic_h_hapke_2002(double mu, double albedo);

}  // namespace lamella
