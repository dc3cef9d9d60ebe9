#pragma once

#include "phase/math/direction.h"
#include "phase/math/real.h"
#include "phase/surface/fresnel_formulas.h"
#include "phase/surface/microfacet.h"

namespace lamella {

/// Single scattering of rough conductors and dielectrics (microfacet_model.h) over any number type
/// that has erf, exp, log, sqrt and abs: what Conductor::single and Dielectric::single are in
/// double, for |mu| of kLeastCosine and above. Relative difference to those: see
/// tests/analytic/model/batch_test.cpp.
struct FacetFormula {
  static constexpr double kLeastCosine = 1e-9;

  bool ggx = true;
  Masking masking = Masking::beta;
  double alpha_x = 0, alpha_y = 0;
  double ratio = 0;  ///< of dielectrics: index below over above; 0: a conductor
  bool white = false;
  double eta[3] = {}, k[3] = {};

  /// Area of the facets that w above the surface sees, per area of the surface.
  template <class Real>
  [[nodiscard]] LAMELLA_INLINE Real area(Vec3<Real> w) const {
    using std::erf, std::exp, std::sqrt;
    const Real x = Real(alpha_x) * w.x, y = Real(alpha_y) * w.y;
    const Real s2 = multiply_add(x, x, y * y);
    if (ggx) return Real(0.5) * (w.z + sqrt(multiply_add(w.z, w.z, s2)));
    const Real s = sqrt(max(s2, Real(1e-100))), c = w.z / s;
    return Real(0.5) *
           multiply_add(w.z, Real(1) + erf(c), Real(0.56418958354775628695) * s * exp(-(c * c)));
  }

  /// D(m) [1/sr] of m above the surface, m.z > 0.
  template <class Real>
  [[nodiscard]] LAMELLA_INLINE Real density(Vec3<Real> m) const {
    using std::exp;
    const Real x = m.x / Real(alpha_x), y = m.y / Real(alpha_y), z2 = m.z * m.z;
    const Real slopes2 = multiply_add(x, x, y * y), scale = Real(kPi * alpha_x * alpha_y);
    const Real t = slopes2 + z2;
    if (ggx) return Real(1) / (scale * t * t);
    return exp(-(slopes2 / z2)) / (scale * z2 * z2);
  }

  /// Euler's Beta function of a, b in [1, 1e15]: Stirling's series nine and more from 0.
  template <class Real>
  [[nodiscard]] LAMELLA_INLINE static Real beta(Real a, Real b) {
    using std::exp, std::log;
    constexpr int kShift = 8;
    Real above(1), below(1);
    for (int n = 0; n < 2 * kShift; ++n) above = above * (a + b + Real(n));
    for (int n = 0; n < kShift; ++n) below = below * ((a + Real(n)) * (b + Real(n)));
    const Real larger = max(a, b) + Real(kShift), smaller = min(a, b) + Real(kShift);
    const Real sum = larger + smaller, share = smaller / sum;
    // log(1 - share), by Kahan's quotient
    const Real rest = Real(1) - share;
    const Real shy = Real(1) - rest;
    const Real log_rest = select(shy > Real(0), log(rest) * share / max(shy, Real(1e-30)), -share);
    const auto series = [](Real x) LAMELLA_INLINE_LAMBDA {
      const Real r = Real(1) / x;
      return r * polynomial(r * r, 1.0 / 12, -1.0 / 360, 1.0 / 1260, -1.0 / 1680, 1.0 / 1188,
                            -691.0 / 360360, 1.0 / 156);
    };
    const Real exponent = Real(0.91893853320467274178) + (larger - Real(0.5)) * log_rest +
                          (smaller - Real(0.5)) * log(share) - Real(0.5) * log(sum) +
                          series(larger) + series(smaller) - series(sum);
    return exp(exponent) * (above / below);
  }

  /// Facets::shadowing of two directions above the surface.
  template <class Real>
  [[nodiscard]] LAMELLA_INLINE Real shadowing(bool transmission, Vec3<Real> wi,
                                              Vec3<Real> wo) const {
    const Real i = area(wi), o = area(wo);
    if (masking == Masking::separable) return Real(1) / (i * o);
    if (masking == Masking::correlated || !transmission)
      return Real(1) / (wo.z * i + wi.z * (o - wo.z));
    return beta(i / wi.z, o / wo.z) / (wi.z * wo.z);
  }

  /// f of light from w_i to w_o, `f` of `channels`.
  template <class Real>
  LAMELLA_INLINE void evaluate(Vec3<Real> wi, Vec3<Real> wo, int channels, Real* f) const {
    using std::abs, std::sqrt;
    const Real zero(0);
    const auto turned = wi.z < zero;
    wi = select(turned, -wi, wi);
    wo = select(turned, -wo, wo);
    const auto reflects = wo.z > zero;
    const Vec3<Real> lifted{wo.x, wo.y, abs(wo.z)};
    Vec3<Real> h = wi + wo;
    h = (Real(1) / sqrt(max(dot(h, h), Real(1e-200)))) * h;
    const Real ci = dot(wi, h);
    const Real reflected = Real(0.25) * density(h) * shadowing(false, wi, lifted);
    if (ratio == 0) {
      for (int c = 0; c < channels; ++c) {
        const Real share =
            white ? Real(1)
                  : conductor_reflectance(min(nonnegative(ci), Real(1)), Real(eta[c]), Real(k[c]));
        f[c] = select(reflects & !turned, reflected * share, zero);
      }
      return;
    }
    const Real n = select(turned, Real(1 / ratio), Real(ratio));
    f[0] = select(reflects, reflected * refraction(nonnegative(ci), n).reflectance, zero);
    if (!any(!reflects)) return;
    Vec3<Real> g = -wi - n * wo;
    g = (Real(1) / sqrt(max(dot(g, g), Real(1e-200)))) * g;
    g = select(g.z < zero, -g, g);
    const Real di = dot(wi, g), dot_o = dot(wo, g);
    const auto passes = (di > zero) & (dot_o < zero) & (g.z > zero);
    const Real t = multiply_add(n, dot_o, di);
    const Real share = Real(1) - refraction(nonnegative(di), n).reflectance;
    const Real through =
        share * density(g) * di * (n * n * -dot_o / (t * t)) * shadowing(true, wi, lifted);
    f[0] = select(reflects, f[0], select(passes, through, zero));
  }
};

}  // namespace lamella
