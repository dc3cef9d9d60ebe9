#pragma once

#include "analytic/model/reflection_angles.h"

namespace lamella {

// The formulas of analytic/rough_surface/oren_nayar.h over any number type; that header has their
// meaning.

/// s+ / max(mu_i, mu_o) of the qualitative models, EON eq. 4.
template <class Real>
[[nodiscard]] Real oren_nayar_term(const Angles<Real>& a) {
  return nonnegative(a.sines_cos) / max(a.mu_i, a.mu_o);
}

/// s / t of Fujii's models, EON eq. 11.
template <class Real>
[[nodiscard]] Real fujii_term(const Angles<Real>& a) {
  return a.sines_cos / select(a.sines_cos > Real(0), max(a.mu_i, a.mu_o), Real(1));
}

/// rho / pi (A + B s / t); kFujii: t is 1 where s is negative.
template <bool kFujii>
struct QualitativeFormula {
  double rho[3], a[3], b;  ///< rho / pi, A per channel; B

  /// The factor that the channels share: B s / t.
  template <class Real>
  [[nodiscard]] Real shared(const Angles<Real>& angles) const {
    return Real(b) * (kFujii ? fujii_term(angles) : oren_nayar_term(angles));
  }
  template <class Real>
  [[nodiscard]] Real channel(Real term, int c) const {
    return Real(rho[c]) * (Real(a[c]) + term);
  }
};

/// The full model.
struct FullOrenNayarFormula {
  double rho[3], rho2[3];          ///< rho / pi, rho^2 / pi
  double c1, c2, c3, interaction;  ///< C1; the factors of C2, C3 and of the second lobe

  template <class Real>
  struct Shared {
    Real single, twice;
  };
  template <class Real>
  [[nodiscard]] Shared<Real> shared(const Angles<Real>& a) const {
    // The angle nearer to grazing is alpha, whose sine is the larger one.
    const auto i_grazes = a.mu_i < a.mu_o;
    const Real mu_b = max(a.mu_i, a.mu_o);
    const Real sin_a = select(i_grazes, a.sin_i, a.sin_o);
    const Real sin_b = select(i_grazes, a.sin_o, a.sin_i);
    const Real low = min(a.mu_i, a.mu_o);
    const Real alpha = Real(2 / kPi) * angle_of(sin_a, low);
    const Real beta = Real(2 / kPi) * angle_of(sin_b, mu_b);
    const Real zero = Real(0), one = Real(1), x = a.cos_phi, ab = alpha * beta;
    // sin(alpha) - (2 beta / pi)^3 where cos(phi) < 0: both are 1 less what vanishes at grazing,
    // and their difference is that of the two parts.
    const Real gone = Real(2 / kPi) * arc_sine(mu_b, sin_b);
    const Real lobe = select(
        x < zero, gone * multiply_add(gone, gone - Real(3), Real(3)) - low * low / (one + sin_a),
        sin_a);
    const Real tan_mean = (sin_a + sin_b) / (a.mu_i + a.mu_o);  // tan((alpha + beta) / 2)
    return {Real(c1) + x * Real(c2) * lobe * (sin_b / mu_b) +
                (one - max(x, -x)) * Real(c3) * (ab * ab) * tan_mean,
            Real(interaction) * (one - x * (beta * beta))};
  }
  template <class Real>
  [[nodiscard]] Real channel(const Shared<Real>& s, int c) const {
    return Real(rho[c]) * s.single + Real(rho2[c]) * s.twice;
  }
};

}  // namespace lamella
