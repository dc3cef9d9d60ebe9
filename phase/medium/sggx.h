#pragma once

#include <array>
#include <optional>

#include "phase/medium/sggx_formulas.h"
#include "phase/random/random.h"

namespace lamella {

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
  /// The same by h = w_i + w_o and |h|^2, for many w_o.
  struct MirrorLobe {
    const SggxMatrix<double>& inverse;  ///< A^-1
    double scale;                       ///< 1 / (4 pi sqrt(det S) sigma(w_i))

    [[nodiscard]] double operator()(Direction h, double h2) const {
      const Direction u = inverse.apply(h);
      return scale * normal_density_of(h2, dot(u, u));
    }
  };
  [[nodiscard]] MirrorLobe mirror_lobe(Direction wi) const {
    return {inverse_, mirror_scale_ / sigma(wi)};
  }
  /// integral of D(m) <w_i, m> <w_o, m> dm / (pi sigma(w_i)): about the axis, the azimuth in closed
  /// form, where S has a double eigenvalue (relative error below 1e-8, 1e-6 at alpha 0.001); else
  /// over the lune that both directions see (1e-7; slower, the more so the further apart the
  /// eigenvalues are).
  [[nodiscard]] double diffuse_phase(Direction wi, Direction wo) const;
  [[nodiscard]] bool is_delta() const { return false; }

  [[nodiscard]] bool is_two_sided() const { return true; }
  [[nodiscard]] Direction mean_normal() const { return {0, 0, 0}; }
  /// An upper bound of mirror_phase [1/sr], from the norms of A and its inverse.
  [[nodiscard]] double largest_mirror_phase() const;

  [[nodiscard]] const SggxMatrix<double>& matrix() const { return a_; }
  /// S commutes with every rotation about z.
  [[nodiscard]] bool is_symmetric_about_z() const { return symmetric_about_z_; }

  /// diffuse_phase by the quadrature over the lune, for any S.
  [[nodiscard]] double diffuse_phase_over_lune(Direction wi, Direction wo) const;

  friend bool operator==(const Sggx& a, const Sggx& b) { return a.a_ == b.a_; }

 private:
  /// S = across^2 (I - n n^T) + along^2 n n^T
  struct Axial {
    Direction axis;
    double along, across;
  };
  [[nodiscard]] static std::optional<Axial> axial_form(const std::array<double, 6>& s);
  [[nodiscard]] double diffuse_phase_about_axis(Direction wi, Direction wo) const;

  SggxMatrix<double> a_{}, inverse_{};
  double mirror_scale_ = 0;  // 1 / (4 pi sqrt(det S))
  std::optional<Axial> axial_;
  bool symmetric_about_z_ = false;
};

}  // namespace lamella
