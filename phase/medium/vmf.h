#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "phase/math/sampling.h"
#include "phase/random/random.h"

namespace lamella {

/// Shape of the von Mises-Fisher distribution of normals, kappa = 2 / alpha^2:
/// D(m) = kappa exp(kappa (m.n - 1)) / (2 pi (1 - exp(-2 kappa))) [1/sr], integral over the
/// sphere 1. d'Eon and Weidlich 2024, "VMF Diffuse", eq. 1, written so that nothing overflows.
/// alpha in [0, infinity]; 0 is a delta along the mean normal n, infinity is uniform.
[[nodiscard]] double vmf_concentration(double alpha);

/// alpha = -log(1 - sqrt(r)) for the roughness r in [0, 1] (VMF Diffuse, eq. 2).
[[nodiscard]] double vmf_alpha(double roughness);

/// D by the cosine with the mean normal, for 0 <= kappa < infinity.
[[nodiscard]] double vmf_density(double kappa, double cosine);

/// Natural logarithm of the projected area sigma(u) = integral of D(m) <w, m> dm, u = w.n in
/// [-1, 1], for any alpha in [0, infinity]; -infinity where sigma is 0 (alpha = 0, u <= 0).
/// Equivalent to VMF Diffuse eq. 3; composite Gauss-Legendre quadrature in the frame of w, front
/// and back tied by vmf_mean_cosine. Absolute error below 1e-11 max(1, |log sigma| 1e-4).
[[nodiscard]] double log_vmf_sigma(double u, double alpha);

/// The projected area itself: relative error below 1e-10 wherever it exceeds 1e-300.
[[nodiscard]] double vmf_sigma(double u, double alpha);

/// sigma(u) - sigma(-u) = u times this: the integral of (m.n) D(m), coth(kappa) - 1 / kappa.
[[nodiscard]] double vmf_mean_cosine(double kappa);

/// One-sided von Mises-Fisher flakes' distribution of normals, as the media use it.
class Vmf {
 public:
  /// alpha in [0, infinity]; axis: unit, the mean normal.
  Vmf(double alpha, Direction axis);

  /// Projected area from a table of polynomials with the exact sigma(u) - sigma(-u): absolute error
  /// below 1e-12; 0 where it is below 1e-30.
  [[nodiscard]] double sigma(Direction w) const { return sigma_of_cosine(dot(w, axis_)); }
  [[nodiscard]] double density_of(Direction h) const;
  /// Exact at every roughness by rejection with a bounded expected number of tries: the projected
  /// cosine is at most |u| times the axial plus sin times the tangential one, each of which can be
  /// sampled; from far behind, in the frame of w_i instead; normals from D where most face w_i.
  [[nodiscard]] Direction visible_normal(Direction wi, RandomStream& stream) const;
  /// The same distribution by VMF Diffuse's null collisions: normals from D, accepted with the
  /// projected cosine. Its cost is unbounded; kept as the independent check.
  [[nodiscard]] Direction visible_normal_by_null_collisions(Direction wi,
                                                            RandomStream& stream) const;
  /// A normal from D itself.
  [[nodiscard]] Direction sample_normal(RandomStream& stream) const;

  /// D(h) / (4 sigma(w_i)), in log space where both underflow; 0 where sigma < exp(-1e10).
  [[nodiscard]] double mirror_phase(Direction wi, Direction wo) const;
  /// The same by h = w_i + w_o and |h|^2, for many w_o.
  struct MirrorLobe {
    const Vmf& ndf;
    Direction wi;
    double scale;  ///< D at the axis over 4 sigma(w_i); 0: in log space

    [[nodiscard]] double operator()(Direction h, double h2) const {
      if (!(scale > 0)) return ndf.mirror_phase(wi, h - wi);
      const double cosine = dot(h, ndf.axis_) / std::sqrt(h2);
      return scale * std::exp(ndf.kappa_ * (std::min(cosine, 1.0) - 1));
    }
  };
  [[nodiscard]] MirrorLobe mirror_lobe(Direction wi) const;
  /// integral of D(m) <w_i, m> <w_o, m> dm / (pi sigma(w_i)): quadrature by panels over the cosine
  /// with the mean normal, the azimuth in closed form. Relative error below 1e-7 + 1e-15 kappa, as
  /// cosines near 1 round; for alpha < 1e-5 the cosine with the likeliest visible normal instead,
  /// absolute error of the order of alpha wherever sigma > 0.
  [[nodiscard]] double diffuse_phase(Direction wi, Direction wo) const;
  /// alpha = 0: every normal is the mean normal.
  [[nodiscard]] bool is_delta() const { return alpha_ == 0; }

  [[nodiscard]] bool is_two_sided() const { return false; }
  [[nodiscard]] bool is_symmetric_about_z() const {
    return std::isinf(alpha_) || (axis_.x == 0 && axis_.y == 0);
  }
  /// Twice the largest value of mirror_phase [1/sr] on a fine set of cosines.
  [[nodiscard]] double largest_mirror_phase() const;

  [[nodiscard]] double alpha() const { return alpha_; }
  [[nodiscard]] Direction axis() const { return axis_; }
  /// The integral of m D(m) dm, whose z part is the kappa_k of the transmission law.
  [[nodiscard]] Direction mean_normal() const { return mean_cosine_ * axis_; }

  friend bool operator==(const Vmf& a, const Vmf& b) {
    return a.alpha_ == b.alpha_ && a.axis_ == b.axis_;
  }

 private:
  static constexpr int kPieces = 32;
  static constexpr int kDegree = 8;

  [[nodiscard]] double sigma_of_cosine(double u) const;
  [[nodiscard]] double back_sigma(double x) const;
  [[nodiscard]] Direction normal_by_tries(Direction wi, double u, RandomStream& stream) const;
  [[nodiscard]] Direction normal_by_mixture(Direction wi, double u, RandomStream& stream) const;
  [[nodiscard]] Direction normal_from_behind(Direction wi, double u, RandomStream& stream) const;

  double alpha_, kappa_;
  Direction axis_;
  double mean_cosine_;
  double front_ = 0, back_ = 0, side_ = 0;  // sigma(1), sigma(-1), sigma(0)
  // sigma(-x) for x in [0, table_end_] as polynomials; beyond, below 1e-40 and taken as 0.
  double table_end_ = 1;
  std::vector<std::array<double, kDegree + 1>> table_;
};

}  // namespace lamella
