#pragma once

#include "analytic/half_space/h_function.h"
#include "analytic/half_space/three_term_formula.h"
#include "analytic/model/reflection_angles.h"
#include "phase/math/color.h"
#include "phase/medium/lambert_sphere_formulas.h"

namespace lamella {

// The formulas of analytic/half_space/lambert_sphere_models.h over any number type; that header has
// their meaning, sources and errors. Each is albedo * single + multiple per channel.

/// Exact single scattering for c = 1 (eq. 17).
template <class Real>
[[nodiscard]] Real lambert_sphere_single_of(const Angles<Real>& a) {
  const Real cosine = -multiply_add(a.mu_i, a.mu_o, a.sines_cos);
  return lambert_sphere_phase(max(Real(-1), min(Real(1), cosine))) / (a.mu_i + a.mu_o);
}

/// H0 of eq. 37 for one albedo: (1 + a mu^d) / (1 + a mu^d / H0(infinity)).
struct LambertSphereH0 {
  double a, d, limit;  ///< limit: 1 / H0(infinity), 0 at c = 1

  explicit LambertSphereH0(double albedo);
  template <class Real>
  [[nodiscard]] Real operator()(Real log_mu) const {
    using std::exp;
    const Real power = Real(a) * exp(Real(d) * log_mu);
    return (Real(1) + power) / multiply_add(power, Real(limit), Real(1));
  }
};

/// mu^E(mu), E as in eq. 29: log H1 is this times a factor of the albedo.
template <class Real>
[[nodiscard]] Real lambert_sphere_h1_power(Real mu, Real log_mu) {
  using std::exp;
  return exp(polynomial(mu, 0.459442, -1.07879, 1.85728, -1.12831) * log_mu);
}

/// Eqs. 35, 45: modes 0 and 1 of three-term scattering without their order 1.
struct AnalyticLambertSphere {
  struct Channel {
    double albedo;
    LambertSphereH0 h0;
    double h1;  ///< log H1 of mu^E(mu) = 1
    double w1, w2;
    double a, b, c, d, e, f, l, n;
  };
  Channel channels[3];

  template <class Real>
  struct Shared {
    Real single, log_i, log_o, powers, product, sum, squares, scale, sines_cos, legendres;
  };
  template <class Real>
  [[nodiscard]] Shared<Real> shared(const Angles<Real>& a) const {
    using std::log;
    const Real x = a.mu_i, y = a.mu_o, log_i = log(x), log_o = log(y), sum = x + y;
    return {.single = lambert_sphere_single_of(a),
            .log_i = log_i,
            .log_o = log_o,
            .powers = lambert_sphere_h1_power(x, log_i) + lambert_sphere_h1_power(y, log_o),
            .product = x * y,
            .sum = sum,
            .squares = multiply_add(x, x, y * y),
            .scale = Real(1) / sum,
            .sines_cos = a.sines_cos,
            .legendres = legendre_2(x) * legendre_2(y)};
  }
  template <class Real>
  [[nodiscard]] Real multiple(const Shared<Real>& s, int channel) const {
    using std::exp;
    const Channel& k = channels[channel];
    const Real p = s.product;
    const Real f0 = Real(1 / (2 * kPi)) * k.h0(s.log_i) * k.h0(s.log_o) *
                    (Real(k.a) + multiply_add(Real(k.d), p, Real(k.b)) * s.sum +
                     multiply_add(Real(k.e), p, Real(k.c)) * p + Real(k.f) * s.squares);
    const Real f1 = Real(k.albedo / (3 * kPi)) * exp(Real(k.h1) * s.powers) *
                    multiply_add(Real(k.l), s.sum, multiply_add(Real(k.n), p, Real(1)));
    // Order 1 of the three terms, x and -y being the cosines.
    const Real mean = three_term_mean(k.albedo, k.w1, k.w2, -p, s.legendres);
    const Real slope = three_term_slope(k.w1, k.w2, -p);
    return s.scale * (f0 - mean + (f1 + slope) * s.sines_cos);
  }
  template <class Real>
  [[nodiscard]] Real channel(const Shared<Real>& s, int c) const {
    return multiply_add(Real(channels[c].albedo), s.single, multiple(s, c));
  }
};

[[nodiscard]] AnalyticLambertSphere lambert_sphere_formula(Rgb albedo);

/// Eq. 48 without its f_1, so that the sum of both is its maximum with 0.
struct FastLambertSphere {
  double albedo[3], base[3], factor[3];

  template <class Real>
  struct Shared {
    Real single, lift;
  };
  template <class Real>
  [[nodiscard]] Shared<Real> shared(const Angles<Real>& a) const {
    using std::sqrt;
    const Real one = Real(1), s = min(one, a.sin_i * a.sin_o);
    const Real arc = angle_of(sqrt((one - s) * (one + s)), s);
    // s / (acos(s) + 0.113706 s) is the reciprocal of the printed denominator, finite at s = 0.
    return {lambert_sphere_single_of(a),
            (a.phi() + sqrt(a.mu_i * a.mu_o)) * s / multiply_add(Real(0.113706), s, arc)};
  }
  template <class Real>
  [[nodiscard]] Real multiple(const Shared<Real>& s, int c) const {
    return max(Real(-albedo[c]) * s.single, multiply_add(Real(factor[c]), s.lift, Real(base[c])));
  }
  template <class Real>
  [[nodiscard]] Real channel(const Shared<Real>& s, int c) const {
    return multiply_add(Real(albedo[c]), s.single, multiple(s, c));
  }
};

/// Hapke's model.
struct HapkeLambertSphere {
  double albedo[3], root[3];  ///< root: sqrt(1 - albedo)

  template <class Real>
  struct Shared {
    Real single, scale, mu_i, mu_o;
  };
  template <class Real>
  [[nodiscard]] Shared<Real> shared(const Angles<Real>& a) const {
    return {lambert_sphere_single_of(a), Real(1 / (4 * kPi)) / (a.mu_i + a.mu_o), a.mu_i, a.mu_o};
  }
  template <class Real>
  [[nodiscard]] Real multiple(const Shared<Real>& s, int c) const {
    const Real i = hapke_1981_rise(s.mu_i, root[c]), o = hapke_1981_rise(s.mu_o, root[c]);
    return Real(albedo[c]) * s.scale * (i + o + i * o);  // H H - 1
  }
  template <class Real>
  [[nodiscard]] Real channel(const Shared<Real>& s, int c) const {
    return multiply_add(Real(albedo[c]), s.single, multiple(s, c));
  }
};

}  // namespace lamella
