#pragma once

#include "phase/math/direction.h"
#include "phase/math/real.h"

namespace lamella {

// The fits of d'Eon and Weidlich 2024, "VMF Diffuse", to the projected area of one-sided von
// Mises-Fisher flakes, sigma(u) = integral of D(m) <w, m> dm, u = w.n in [-1, 1], dimensionless.
// alpha >= 0: see phase/medium/vmf.h, whose vmf_sigma is the exact value. Errors are absolute,
// measured against that. Terms that depend on alpha alone are computed once; u is of any number
// type.

/// Eq. 4 with the sign of its exponent corrected to exp(-u^2 / (alpha^2 (1 - u^2))). For alpha in
/// [0, 0.25); error below 9.5e-4 from alpha = 0.02, at 0 exact. sigma(u) - sigma(-u) is exact up
/// to exp(-2 / alpha^2).
struct VmfSmoothSigma {
  double alpha, tanh;  ///< tanh(1 / alpha^2)

  explicit VmfSmoothSigma(double alpha);
  template <class Real>
  [[nodiscard]] Real operator()(Real u) const {
    using std::erf;
    using std::exp;
    using std::sqrt;
    if (alpha == 0) return nonnegative(u);
    const double a2 = alpha * alpha;
    const Real small = Real(tanh - a2 - 2 + 1 / tanh) * u - Real(tanh * a2) * max(u, -u);
    const Real width = Real(alpha) * sqrt((Real(1) - u) * (Real(1) + u));
    const Real x = u / width;  // infinite at |u| = 1: erf and exp have their limits there
    const Real gauss = width * exp(-x * x) * Real(std::numbers::inv_sqrtpi);
    return Real(0.25) * small + Real(0.5) * (u * (erf(x) + Real(1)) + gauss);
  }
};

/// Eq. 5 as printed. For alpha in [0.25, 0.9); error below 0.024 (at alpha = 0.8, u = 1), negative
/// down to -0.006 near u = -1.
struct VmfMiddleSigma {
  double p1, p2, p4, p8, wave;

  explicit VmfMiddleSigma(double alpha);
  template <class Real>
  [[nodiscard]] Real operator()(Real u) const {
    using std::cos;
    const Real u2 = u * u;
    return multiply_add(Real(p1), u,
                        polynomial(u2, 0.25 - p2 - 3 * p4, 3 * p2 + 30 * p4, -35 * p4, 0.0, p8)) -
           Real(wave) * cos(Real(7.7) * u);
  }
};

/// Eq. 6, two terms beyond 1/4, written in coth(kappa) - 1 / kappa, kappa = 2 / alpha^2, so that
/// nothing cancels for large alpha. For alpha in [0.9, infinity]; error below 2.1e-3.
struct VmfRoughSigma {
  double mean, second;  ///< Legendre moments of D, over 2 and times 5 / 32

  explicit VmfRoughSigma(double alpha);
  template <class Real>
  [[nodiscard]] Real operator()(Real u) const {
    return polynomial(u, 0.25 - second, mean, 3 * second);
  }
};

/// The one of the three that its range asks for. Jumps at the joints by up to 6.7e-3 (alpha =
/// 0.25, which the paper leaves out and which is eq. 5's here) and 1.7e-2 (alpha = 0.9).
struct VmfSigmaFit {
  enum class Range { smooth, middle, rough } range;
  VmfSmoothSigma smooth;
  VmfMiddleSigma middle;
  VmfRoughSigma rough;

  explicit VmfSigmaFit(double alpha);
  template <class Real>
  [[nodiscard]] Real operator()(Real u) const {
    switch (range) {
      case Range::smooth:
        return smooth(u);
      case Range::middle:
        return middle(u);
      default:
        return rough(u);
    }
  }
};

[[nodiscard]] double vmf_sigma_fit_smooth(double u, double alpha);
[[nodiscard]] double vmf_sigma_fit_middle(double u, double alpha);
[[nodiscard]] double vmf_sigma_fit_rough(double u, double alpha);
[[nodiscard]] double vmf_sigma_fit(double u, double alpha);

}  // namespace lamella
