#pragma once

#include <array>
#include <optional>

#include "phase/random.h"
#include "phase/sampling.h"

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
    return {a00 * u.x, a10 * u.x + a11 * u.y, a20 * u.x + a21 * u.y + a22 * u.z};
  }
  /// A^T w, whose length is the projected area
  [[nodiscard]] Vec3<Real> apply_transposed(Vec3<Real> w) const {
    return {a00 * w.x + a10 * w.y + a20 * w.z, a11 * w.y + a21 * w.z, a22 * w.z};
  }
  /// A^-1 m by forward substitution
  [[nodiscard]] Vec3<Real> solve(Vec3<Real> m) const {
    const Real x = m.x / a00;
    const Real y = (m.y - a10 * x) / a11;
    return {x, y, (m.z - a20 * x - a21 * y) / a22};
  }
  [[nodiscard]] Real determinant() const { return a00 * a11 * a22; }
};

/// Projected area sigma(w) = sqrt(w^T S w) = |A^T w|, dimensionless. w: unit.
/// Heitz et al. 2015, eq. 8.
template <class Real>
[[nodiscard]] Real projected_area(const SggxMatrix<Real>& a, Vec3<Real> w) {
  return length(a.apply_transposed(w));
}

/// D(h / |h|) = |h|^4 / (pi sqrt(det S) (h^T S^-1 h)^2) [1/sr]; h need not be unit.
/// SpongeCake eq. 7 with sqrt(det S) for the alpha printed there.
template <class Real>
[[nodiscard]] Real normal_density(const SggxMatrix<Real>& a, Vec3<Real> h) {
  const Vec3<Real> u = a.solve(h);
  const Real ratio = dot(h, h) / dot(u, u);
  return ratio * ratio / (Real(kPi) * a.determinant());
}

/// A normal visible from the unit direction w, density D(m) <w, m> / sigma(w), from two uniforms:
/// m is along A u with u about v = A^T w by the cosine law, u along v + |v| times a uniform point
/// of the sphere. No frame, no trigonometry but that of the uniform point, lengths taken once.
template <class Real>
[[nodiscard]] Vec3<Real> visible_normal(const SggxMatrix<Real>& a, Vec3<Real> w, Real u1, Real u2) {
  const Vec3<Real> v = a.apply_transposed(w);
  const Vec3<Real> u = v + length(v) * uniform_sphere(u1, u2);
  if (!(dot(u, u) > Real(0))) return normalized(a.apply(v));
  return normalized(a.apply(u));
}

/// The distribution as the media use it.
class Sggx {
 public:
  /// S as xx, yy, zz, xy, xz, yz; must be positive definite (see is_positive_definite).
  explicit Sggx(const std::array<double, 6>& s);

  /// Surface-like flakes: S = alpha^2 (I - n n^T) + n n^T. alpha in (0, 1], n unit.
  [[nodiscard]] static std::array<double, 6> surface_matrix(double alpha, Direction n);
  /// Fiber-like flakes: S = (I - t t^T) + alpha^2 t t^T. alpha in (0, 1], t unit.
  [[nodiscard]] static std::array<double, 6> fiber_matrix(double alpha, Direction t);
  /// Whether S is positive definite beyond rounding: diagonal entries in [1e-12, 1e12], and
  /// Cholesky pivots above 1e-12 of them (what is lost there is lost in D).
  [[nodiscard]] static bool is_positive_definite(const std::array<double, 6>& s);

  [[nodiscard]] double sigma(Direction w) const { return projected_area(a_, w); }
  [[nodiscard]] double density_of(Direction h) const { return normal_density(a_, h); }
  [[nodiscard]] Direction visible_normal(Direction wi, RandomStream& stream) const {
    const double u1 = stream.uniform(), u2 = stream.uniform();
    return lamella::visible_normal(a_, wi, u1, u2);
  }
  /// D(h) / (4 sigma(w_i)), h the half vector (its limit in the vertical plane at w_o = -w_i).
  [[nodiscard]] double mirror_phase(Direction wi, Direction wo) const;
  /// integral of D(m) <w_i, m> <w_o, m> dm / (pi sigma(w_i)): about the axis, the azimuth in closed
  /// form, where S has a double eigenvalue (relative error below 1e-8, 1e-6 at alpha 0.001); else
  /// over the lune that both directions see, far slower (1e-7 down to alpha 0.5, not tested below).
  [[nodiscard]] double diffuse_phase(Direction wi, Direction wo) const;
  [[nodiscard]] bool is_delta() const { return false; }

  [[nodiscard]] const SggxMatrix<double>& matrix() const { return a_; }
  /// S commutes with every rotation about z.
  [[nodiscard]] bool is_symmetric_about_z() const { return symmetric_about_z_; }

  /// diffuse_phase by the quadrature over the lune, for any S.
  [[nodiscard]] double diffuse_phase_over_lune(Direction wi, Direction wo) const;

 private:
  /// S = across^2 (I - n n^T) + along^2 n n^T
  struct Axial {
    Direction axis;
    double along, across;
  };
  [[nodiscard]] static std::optional<Axial> axial_form(const std::array<double, 6>& s);
  [[nodiscard]] double diffuse_phase_about_axis(Direction wi, Direction wo) const;

  SggxMatrix<double> a_{};
  std::optional<Axial> axial_;
  bool symmetric_about_z_ = false;
};

}  // namespace lamella
