#pragma once

#include "phase/math/sampling.h"

namespace lamella {

/// The SGGX distribution of normals: two-sided, the normals of an ellipsoid (Heitz et al. 2015,
/// "The SGGX microflake distribution"). With S = A A^T, A lower triangular, and u a point of the
/// unit sphere, the normal m along A u turns the flakes' area D(m) dm into |A u| du / pi, because
/// dm = |det A| / |A u|^3 du. Every formula below is that substitution.
/// Normalisation: sigma(w) = sqrt(w^T S w), so D integrates to 4 at S = I.
template <class Real>
struct SggxMatrix {
  Real a00, a10, a11, a20, a21, a22;

  /// A u
  [[nodiscard]] Vec3<Real> apply(Vec3<Real> u) const {
    return {a00 * u.x, multiply_add(a10, u.x, a11 * u.y),
            multiply_add(a21, u.y, a20 * u.x) + a22 * u.z};
  }
  /// A^T w, whose length is the projected area
  [[nodiscard]] Vec3<Real> apply_transposed(Vec3<Real> w) const {
    return {multiply_add(a10, w.y, a00 * w.x) + a20 * w.z, multiply_add(a11, w.y, a21 * w.z),
            a22 * w.z};
  }
  /// A^-1 m by forward substitution
  [[nodiscard]] Vec3<Real> solve(Vec3<Real> m) const {
    const Real x = m.x / a00;
    const Real y = (m.y - a10 * x) / a11;
    return {x, y, (m.z - a20 * x - a21 * y) / a22};
  }
  [[nodiscard]] Real determinant() const { return a00 * a11 * a22; }
  /// A^-1, lower triangular too.
  [[nodiscard]] SggxMatrix inverse() const {
    const Vec3<Real> x = solve({Real(1), Real(0), Real(0)}), y = solve({Real(0), Real(1), Real(0)}),
                     z = solve({Real(0), Real(0), Real(1)});
    return {x.x, x.y, y.y, x.z, y.z, z.z};
  }

  friend bool operator==(const SggxMatrix&, const SggxMatrix&) = default;
};

/// Projected area sigma(w) = sqrt(w^T S w) = |A^T w|, dimensionless. w: unit.
/// Heitz et al. 2015, eq. 8.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real projected_area(const SggxMatrix<Real>& a,
                                                             Vec3<Real> w) {
  return length(a.apply_transposed(w));
}

/// The part of D that depends on the normal, from |h|^2 and |A^-1 h|^2; finite where both are 0.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real normal_density_of(Real h2, Real u2) {
  const Real ratio = divide(h2, max(u2, Real(1e-30)));
  return ratio * ratio;
}

/// D(h / |h|) = |h|^4 / (pi sqrt(det S) (h^T S^-1 h)^2) [1/sr]; h need not be unit.
/// SpongeCake eq. 7 with sqrt(det S) for the alpha printed there.
template <class Real>
[[nodiscard]] Real normal_density(const SggxMatrix<Real>& a, Vec3<Real> h) {
  const Vec3<Real> u = a.solve(h);
  return normal_density_of(dot(h, h), dot(u, u)) / (Real(kPi) * a.determinant());
}

/// A normal visible from the unit direction w, density D(m) <w, m> / sigma(w), from two uniforms:
/// m is along A u with u about v = A^T w by the cosine law, u along v + |v| times a uniform point
/// of the sphere. No frame, no trigonometry but that of the uniform point, lengths taken once.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> visible_normal(const SggxMatrix<Real>& a,
                                                                   Vec3<Real> w, Real u1, Real u2) {
  const Vec3<Real> v = a.apply_transposed(w);
  const Vec3<Real> u = v + length(v) * uniform_sphere(u1, u2);
  return normalized(a.apply(select(dot(u, u) > Real(0), u, v)));
}

/// A vector of any length along a normal visible from w, from a uniform point of the sphere. A:
/// SggxMatrix or another that has its members.
template <class Real, class A>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> along_visible_normal(const A& a, Vec3<Real> w,
                                                                         Vec3<Real> point) {
  const Vec3<Real> v = a.apply_transposed(w);
  return a.apply(v + length(v) * point);
}

/// A = diag(across, across, along): flakes whose axis is vertical.
template <class Real>
struct UprightSggxMatrix {
  Real across, along;
  [[nodiscard]] LAMELLA_INLINE Vec3<Real> apply(Vec3<Real> u) const {
    return {across * u.x, across * u.y, along * u.z};
  }
  [[nodiscard]] LAMELLA_INLINE Vec3<Real> apply_transposed(Vec3<Real> w) const { return apply(w); }
};

}  // namespace lamella
