#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "volume/algebra/matrix_product.h"
#include "volume/harmonics/harmonic_basis.h"

namespace lamella {

/// Directions that are all pairs of some cosines and some azimuths, direction p of cosine k at
/// k * azimuths + p, between which and spherical harmonics functions are carried cosine by cosine.
class SphereGrid {
 public:
  SphereGrid(const HarmonicBasis& basis, std::vector<double> mu, std::vector<double> phi,
             MatrixProduct product = MatrixProduct());
  /// Quadrature over the sphere: mu = t^2 on each hemisphere with Gauss-Legendre in t, so that
  /// functions with a jump at mu = 0 are integrated, too; even steps of phi, an even number of
  /// them, of which an even basis has the half between 0 and pi. Upwards first.
  static SphereGrid quadrature(const HarmonicBasis& basis, int mu_per_hemisphere, int azimuths,
                               MatrixProduct product = MatrixProduct());

  /// With cosines of a hemisphere and their weights for the integral over them.
  static SphereGrid quadrature(const HarmonicBasis& basis, const Eigen::VectorXd& mu,
                               const Eigen::VectorXd& weight, int azimuths,
                               MatrixProduct product = MatrixProduct());

  [[nodiscard]] int size() const { return static_cast<int>(mu_.size() * phi_.size()); }
  [[nodiscard]] int azimuths() const { return static_cast<int>(phi_.size()); }
  [[nodiscard]] double phi(int p) const { return phi_[p]; }
  [[nodiscard]] double mu(int k) const { return mu_[k / azimuths()]; }
  [[nodiscard]] Direction direction(int k) const;
  [[nodiscard]] double weight(int k) const { return weight_[k / azimuths()]; }  ///< [sr]

  /// From coefficients, a column per function, to values, a row per function.
  [[nodiscard]] Eigen::MatrixXd values(const Eigen::MatrixXd& coefficients) const;
  /// And from values, a row per function, to coefficients, by quadrature.
  [[nodiscard]] Eigen::MatrixXd coefficients(const Eigen::MatrixXd& values) const;

 private:
  HarmonicBasis basis_;
  MatrixProduct product_;
  std::vector<double> mu_, phi_, weight_;
  // By m: rows l, columns mu, and the other way round.
  std::vector<Eigen::MatrixXd> legendre_, legendre_of_l_;
  [[nodiscard]] int waves() const { return basis_.degree() * (basis_.is_even() ? 1 : 2) + 1; }
  [[nodiscard]] int wave(int m, bool sine) const {
    return basis_.is_even() ? m : std::max(0, 2 * m - (sine ? 0 : 1));
  }

  // Columns 1, then cosine and sine of each m, rows phi; and the other way round.
  Eigen::MatrixXd waves_, waves_of_phi_;
};

}  // namespace lamella
