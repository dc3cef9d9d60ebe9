#pragma once

#include "phase/math/sampling.h"

namespace lamella {

/// The normals of a GGX height field, roughness alpha along x and y. Like flakes that face one side
/// only: area(w) is the projected area of the facets that face w, per unit of the macroscopic
/// surface, for w above the surface and below it, area(w) - area(-w) = w.z. Walter et al. 2007,
/// "Microfacet models for refraction through rough surfaces".
template <class Real>
struct GgxFacets {
  Real alpha_x, alpha_y;

  /// w.z (1 + Lambda(w)) = (w.z + sqrt(w.z^2 + s^2)) / 2, s^2 = (alpha_x w.x)^2 + (alpha_y w.y)^2;
  /// below the surface Lambda(-w) |w.z|, in the form that does not cancel.
  [[nodiscard]] LAMELLA_INLINE Real area(Vec3<Real> w) const {
    using std::sqrt;
    const Real x = alpha_x * w.x, y = alpha_y * w.y;
    const Real s2 = multiply_add(x, x, y * y);
    const Real root = sqrt(multiply_add(w.z, w.z, s2));
    return Real(0.5) * select(w.z > Real(0), w.z + root, divide(s2, root - w.z));
  }

  /// area(-w) of w above the surface.
  [[nodiscard]] LAMELLA_INLINE Real hidden_area(Vec3<Real> w) const {
    using std::sqrt;
    const Real x = alpha_x * w.x, y = alpha_y * w.y;
    const Real s2 = multiply_add(x, x, y * y);
    return divide(Real(0.5) * s2, w.z + sqrt(multiply_add(w.z, w.z, s2)));
  }

  /// D(m) [1/sr], integral of D(m) m.z is 1; 0 for m.z <= 0. m: unit.
  [[nodiscard]] LAMELLA_INLINE Real density(Vec3<Real> m) const {
    const Real x = divide(m.x, alpha_x), y = divide(m.y, alpha_y);
    const Real t = multiply_add(x, x, multiply_add(y, y, m.z * m.z));
    return select(m.z > Real(0), reciprocal(Real(kPi) * alpha_x * alpha_y * t * t), Real(0));
  }

  /// A normal visible from w, density D(m) <w, m> / area(w), from two uniforms; w above the surface
  /// or below. In the space where the facets are those of a hemisphere, the normal is half way
  /// between w and a direction uniform on a cap of the sphere.
  /// Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical caps".
  [[nodiscard]] LAMELLA_INLINE Vec3<Real> visible_normal(Vec3<Real> w, Real u1, Real u2) const {
    using std::sqrt;
    const Vec3<Real> v = normalized(Vec3<Real>{alpha_x * w.x, alpha_y * w.y, w.z});
    const Real z = multiply_add(u2, -(Real(1) + v.z), Real(1));  // in (-v.z, 1)
    const Real sine = sqrt(nonnegative((Real(1) - z) * (Real(1) + z)));
    const auto [s, c] = sine_cosine_of_turns(u1);
    const Vec3<Real> h{multiply_add(sine, c, v.x), multiply_add(sine, s, v.y), z + v.z};
    return normalized(Vec3<Real>{alpha_x * h.x, alpha_y * h.y, nonnegative(h.z)});
  }
  /// A visible normal, and area(w).
  struct Visible {
    Vec3<Real> m;
    Real seen;
  };
  /// The same for w above the surface and a uniform azimuth: with numbers of few digits, too,
  /// grazing facets (u near 0) are told apart.
  [[nodiscard]] LAMELLA_INLINE Visible visible(Vec3<Real> w, SineCosine<Real> azimuth,
                                               Real u) const {
    using std::sqrt;
    const Vec3<Real> a{alpha_x * w.x, alpha_y * w.y, w.z};
    const Real size2 = dot(a, a), inverse = reciprocal_sqrt(size2);
    const Vec3<Real> v = inverse * a;
    const Real z = (Real(1) + v.z) * u;  // of h
    const Real sine = sqrt(nonnegative((Real(1) - z + v.z) * (Real(1) + z - v.z)));
    const Vec3<Real> h{multiply_add(sine, azimuth.cosine, v.x),
                       multiply_add(sine, azimuth.sine, v.y), z};
    return {normalized(Vec3<Real>{alpha_x * h.x, alpha_y * h.y, z}),
            Real(0.5) * multiply_add(size2, inverse, w.z)};
  }
};

/// exp(x^2) erfc(x), x >= 0.
LAMELLA_INLINE double scaled_erfc(double x) {
  if (x < 20) return std::exp(x * x) * std::erfc(x);
  const double r = 1 / (x * x);
  return (1 - r * (0.5 - r * (0.75 - 1.875 * r))) / (x * 1.77245385090551602730);
}

/// The normals of a Beckmann height field: slopes are Gaussian. Of directions above the surface.
/// In the space where alpha is 1, w sees the slope x along its azimuth with a density like
/// (c - x) exp(-x^2) for x < c, c the cotangent of w there. Of |x| = y that leaves
/// 2 c exp(-y^2), a Gaussian, and (y - c) exp(-y^2) beyond c: both are drawn exactly, without the
/// inverse of the error function.
template <class Real>
struct BeckmannFacets {
  Real alpha_x, alpha_y;

  /// What the slopes make of a direction.
  struct Seen {
    Real x, y, sine, cotangent;  ///< sine > 0
    Real gaussian, beyond;       ///< the integrals of the two parts
  };
  [[nodiscard]] LAMELLA_INLINE Seen seen_by(Vec3<Real> w) const {
    using std::exp, std::sqrt;
    const Real x = alpha_x * w.x, y = alpha_y * w.y;
    const Real sine = sqrt(max(multiply_add(x, x, y * y), Real(1e-20)));
    const Real c = divide(w.z, sine);
    return {x, y, sine, c, c * Real(1.77245385090551603), exp(-(c * c)) * tail(c, Real(0))};
  }
  /// 1 / 2 - c sqrt(pi) / 2 exp((c + v)^2) erfc(c + v): exp(-(c + v)^2 + c^2) times it is the
  /// integral of u exp(-u^2 - 2 c u) over u > v.
  [[nodiscard]] LAMELLA_INLINE static Real tail(Real c, Real v) {
    return nonnegative(
        multiply_add(c * Real(-0.886226925452758014), scaled_erfc(c + v), Real(0.5)));
  }
  /// area(-w), and area(w) = w.z + area(-w).
  [[nodiscard]] LAMELLA_INLINE static Real hidden_area(const Seen& s) {
    return s.sine * s.beyond * Real(0.56418958354775629);
  }
  [[nodiscard]] LAMELLA_INLINE Real hidden_area(Vec3<Real> w) const {
    return hidden_area(seen_by(w));
  }

  /// A visible normal, density D(m) <w, m> / area(w), from a uniform azimuth, an exponential number
  /// and two uniforms.
  [[nodiscard]] LAMELLA_INLINE Vec3<Real> visible_normal(const Seen& s, SineCosine<Real> azimuth,
                                                         Real exponential, Real which,
                                                         Real u) const {
    using std::abs, std::log, std::sqrt;
    const Real c = s.cotangent;
    const Real radius = sqrt(exponential);
    const Real gauss = abs(radius * azimuth.cosine), across = radius * azimuth.sine;
    // -y, or y with the chance (c - y) / (2 c)
    Real along = select(Real(2) * c * u < c - gauss, gauss, -gauss);
    const auto is_beyond = which * (s.gaussian + s.beyond) < s.beyond;
    if (any(is_beyond)) {
      // y = c + v: v^2 + 2 c v - log(tail(c, v) / tail(c, 0)) is an exponential number, by Newton's
      // method from what it is for small and large v.
      const Real k = max(tail(c, Real(0)), Real(1e-20)), wanted = -log(u);
      Real v = sqrt(Real(2) * k * wanted);
      v = min(v, divide(wanted, c + sqrt(multiply_add(c, c, wanted))));
      for (int step = 0; step < 5; ++step) {
        const Real here = max(tail(c, v), Real(1e-20));
        const Real error = multiply_add(v, v + c + c, -log(divide(here, k))) - wanted;
        v = max(v - error * divide(here, max(v, Real(1e-6))), v * Real(0.25));
      }
      along = select(is_beyond, -(c + v), along);
    }
    const Real inverse = reciprocal(s.sine);
    const auto at_pole = s.sine <= Real(1e-10);
    const Real a = select(at_pole, Real(1), inverse * s.x);
    const Real b = select(at_pole, Real(0), inverse * s.y);
    return normalized(Vec3<Real>{-(a * along - b * across) * alpha_x,
                                 -(b * along + a * across) * alpha_y, Real(1)});
  }
};

}  // namespace lamella
