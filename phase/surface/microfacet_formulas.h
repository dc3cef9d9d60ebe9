#pragma once

#include "phase/math/sampling.h"

namespace lamella {

/// The normals of a GGX height field, roughness alpha along x and y. Like flakes that face one side
/// only: area(w) is what the facets show to w per unit of the macroscopic surface, for w above the
/// surface and below it, area(w) - area(-w) = w.z.
/// Walter et al. 2007, "Microfacet models for refraction through rough surfaces".
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

  /// What the facets show to a direction above the surface, and to the opposite one below it.
  struct Areas {
    Real seen, hidden;
  };
  [[nodiscard]] LAMELLA_INLINE Areas areas(Vec3<Real> w) const {
    using std::sqrt;
    const Real x = alpha_x * w.x, y = alpha_y * w.y;
    const Real s2 = multiply_add(x, x, y * y);
    const Real sum = w.z + sqrt(multiply_add(w.z, w.z, s2));
    return {Real(0.5) * sum, divide(Real(0.5) * s2, sum)};
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
  /// The same for w above the surface and a uniform azimuth: with numbers of few digits, too,
  /// grazing facets (u near 0) are told apart.
  [[nodiscard]] LAMELLA_INLINE Vec3<Real> visible_normal(Vec3<Real> w, SineCosine<Real> azimuth,
                                                         Real u) const {
    using std::sqrt;
    const Vec3<Real> v = normalized(Vec3<Real>{alpha_x * w.x, alpha_y * w.y, w.z});
    const Real z = (Real(1) + v.z) * u;  // of h
    const Real sine = sqrt(nonnegative((Real(1) - z + v.z) * (Real(1) + z - v.z)));
    const Vec3<Real> h{multiply_add(sine, azimuth.cosine, v.x),
                       multiply_add(sine, azimuth.sine, v.y), z};
    return normalized(Vec3<Real>{alpha_x * h.x, alpha_y * h.y, z});
  }
};

}  // namespace lamella
