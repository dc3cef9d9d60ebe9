#pragma once

#include "analytic/rough_surface/oren_nayar_formula.h"

namespace lamella {

/// fon_loss(1): 1/2 - 2 / (3 pi).
inline constexpr double kFonNormalLoss = 0.5 - 2 / (3 * kPi);

/// G_F / pi by eq. 14.
template <class Real>
[[nodiscard]] Real fujii_integral_fit(Real mu) {
  const Real x = Real(1) - mu;
  return x * polynomial(x, 0.0571085289, 0.491881867, -0.332181442, 0.0714429953);
}

/// The share of the light from mu in [0, 1] that FON loses, per unit of A r:
///   (1 - E(mu)) / (A r) = 1/2 - 2 / (3 pi) - G_F(mu) / pi.
/// EON's eqs. 8 and 13 are 0/0 at mu = 0 and lose, near it, all digits of the difference. With
/// s = sqrt(1 - mu^2), q = mu / (1 + s), 1 - s = mu q and theta = pi/2 - asin(mu) it is
///   ((pi/2 - 2/3) mu q + s asin(mu) - mu q^2 s (2 + s) / 3) / pi,
/// whose terms vanish at least like mu. Relative error below 5 epsilon of Real for all mu, 0
/// included. Portsmouth, Kutz and Hill 2025, "EON", eqs. 8, 12, 13.
template <class Real>
[[nodiscard]] Real fon_loss(Real mu) {
  using std::sqrt;
  const Real s = sqrt((Real(1) - mu) * (Real(1) + mu));
  const Real q = mu / (Real(1) + s), mu_q = mu * q;
  const Real tail = mu_q * (q * s) * multiply_add(Real(1 / (3 * kPi)), s, Real(2 / (3 * kPi)));
  return multiply_add(Real(0.5 - 2 / (3 * kPi)), mu_q,
                      multiply_add(Real(1 / kPi) * s, arc_sine(mu, s), -tail));
}

/// The share that FON loses with eq. 14's fit of G_F, clamped at 0: absolute error below 6.2e-4.
template <class Real>
[[nodiscard]] Real fon_loss_fit(Real mu) {
  return nonnegative(Real(kFonNormalLoss) - fujii_integral_fit(mu));
}

enum class EonAlbedo { none, exact, fit };

/// FON and, unless kAlbedo is none, the lobe for the energy that it loses, with that albedo
/// (analytic/rough_surface/eon.h).
template <EonAlbedo kAlbedo>
struct EonFormula {
  double single[3];    ///< rho A / pi
  double multiple[3];  ///< of loss(mu_i) loss(mu_o)
  double roughness;

  /// The loss of FON by the albedo that kAlbedo names.
  template <class Real>
  [[nodiscard]] static Real loss(Real mu) {
    if constexpr (kAlbedo == EonAlbedo::fit)
      return fon_loss_fit(mu);
    else
      return fon_loss(mu);
  }

  template <class Real>
  struct Shared {
    Real single, losses;
  };
  template <class Real>
  [[nodiscard]] Shared<Real> shared(const Angles<Real>& a) const {
    const Real fujii = multiply_add(Real(roughness), fujii_term(a), Real(1));
    if constexpr (kAlbedo == EonAlbedo::none)
      return {fujii, Real(0)};
    else
      return {fujii, loss(a.mu_i) * loss(a.mu_o)};
  }
  template <class Real>
  [[nodiscard]] Real channel(const Shared<Real>& s, int c) const {
    if constexpr (kAlbedo == EonAlbedo::none)
      return Real(single[c]) * s.single;
    else
      return multiply_add(Real(single[c]), s.single, Real(multiple[c]) * s.losses);
  }
};

}  // namespace lamella
