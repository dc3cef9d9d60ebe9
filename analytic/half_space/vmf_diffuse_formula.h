#pragma once

#include "analytic/half_space/vmf_sigma_fit.h"
#include "analytic/model/reflection_angles.h"
#include "phase/math/color.h"

namespace lamella {

// The formulas of analytic/half_space/vmf_diffuse.h over any number type; that header has their
// meaning.

/// Printed modes of f_k for unit albedo over the m-th power of both sines:
/// f_k^(m) = [m] (sin_i sin_o)^m.
template <class Real>
struct VmfModes {
  Real mean, slope, bend;
};

/// The coefficients C_kmj of one roughness, and its projected area.
struct VmfModeFormula {
  VmfSigmaFit sigma;
  double c10[4], c11[3], c12[2], c20[5], c21[3], c30[5], c31[3];

  /// f_1. ui, uo: cosines in (0, 1].
  template <class Real>
  [[nodiscard]] VmfModes<Real> first_order(Real ui, Real uo) const {
    using std::pow;
    const Real si = sigma(ui), so = sigma(uo), sigmas = si * so;
    const Real scale = Real(1 / kPi) / multiply_add(ui, sigma(-uo), uo * si);
    const Real product = ui * uo, squares = multiply_add(ui, ui, uo * uo);
    const Real mean =
        multiply_add(Real(c10[3]), squares, polynomial(product, c10[0], c10[1], c10[2]));
    return {sigmas * scale * mean,
            pow(sigmas, Real(c11[2])) * scale * polynomial(product, c11[0], c11[1]),
            polynomial(ui, c12[0], c12[1]) * polynomial(uo, c12[0], c12[1]) * Real(1 / kPi) /
                (ui + uo)};
  }

  /// f_2 and f_3, by their coefficients of modes 0 and 1.
  template <class Real>
  [[nodiscard]] static VmfModes<Real> higher_order(const double (&a)[5], const double (&b)[3],
                                                   Real ui, Real uo) {
    const Real product = ui * uo, sum = ui + uo, scale = Real(1 / kPi) / sum;
    const Real squares = multiply_add(ui, ui, uo * uo);
    return {
        scale * multiply_add(Real(a[4]), squares,
                             multiply_add(Real(a[2]), sum, polynomial(product, a[0], a[1], a[3]))),
        scale * multiply_add(Real(b[2]), sum, polynomial(product, b[0], b[1])), Real(0)};
  }
};

[[nodiscard]] VmfModeFormula vmf_mode_formula(double roughness);

/// All four lobes.
struct VmfDiffuseFormula {
  struct Channel {
    double albedo, albedo2, albedo3;  ///< and its powers
    double scale;                     ///< of f_m
  };
  VmfModeFormula modes;
  double fold;    ///< the factor of modes 1 and 2: 2, or 1 as printed
  double floor;   ///< of each lobe: 0, or -infinity as printed
  double offset;  ///< of f_m
  Channel channels[3];

  template <class Real>
  struct Shared {
    Real f1, f2, f3, fm;  ///< f_m not clamped and without its scale
  };
  template <class Real>
  [[nodiscard]] Shared<Real> shared(const Angles<Real>& a) const {
    const Real x = a.mu_i, y = a.mu_o;
    const Real squares = (Real(1) - x) * (Real(1) + x) * (Real(1) - y) * (Real(1) + y);
    const Real c1 = Real(fold) * a.sines_cos;  // of cos phi
    const Real twice = Real(2) * a.sines_cos * a.sines_cos;
    const Real c2 = Real(fold) * (twice - squares);  // of cos 2 phi
    const auto sum = [&](const VmfModes<Real>& f) {
      return max(multiply_add(f.bend, c2, multiply_add(f.slope, c1, f.mean)), Real(floor));
    };
    return {sum(modes.first_order(x, y)), sum(modes.higher_order(modes.c20, modes.c21, x, y)),
            sum(modes.higher_order(modes.c30, modes.c31, x, y)), higher_orders(x, y)};
  }
  /// Eq. 9 without its scale.
  template <class Real>
  [[nodiscard]] Real higher_orders(Real ui, Real uo) const {
    return Real(offset) - Real(0.0579) / multiply_add(ui, uo, Real(0.288));
  }
  template <class Real>
  [[nodiscard]] Real highest(Real fm, int c) const {
    return max(Real(channels[c].scale) * fm, Real(floor));
  }
  template <class Real>
  [[nodiscard]] Real channel(const Shared<Real>& s, int c) const {
    const Channel& k = channels[c];
    return multiply_add(
        Real(k.albedo), s.f1,
        multiply_add(Real(k.albedo2), s.f2, multiply_add(Real(k.albedo3), s.f3, highest(s.fm, c))));
  }
};

/// printed: the formulas as printed, without a clamp.
[[nodiscard]] VmfDiffuseFormula vmf_diffuse_formula(Rgb albedo, double roughness, bool printed);

}  // namespace lamella
