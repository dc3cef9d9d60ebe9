#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/algebra/matrix_product.h"
#include "volume/harmonics/harmonic_basis.h"

namespace lamella {

/// Harmonics' coefficients of functions on the sphere, between the slab's frame and one whose z
/// axis is another direction. Columns are functions, rows as HarmonicBasis lists them.
class HarmonicTurn {
 public:
  /// spin: of the other frame about its z [radians]. With an even basis the axis lies in the plane
  /// y = 0, and there is no spin.
  HarmonicTurn(const HarmonicBasis& basis, Direction axis, MatrixProduct product = MatrixProduct(),
               double spin = 0);

  [[nodiscard]] Eigen::MatrixXd to_axis(const Eigen::MatrixXd& coefficients) const;
  [[nodiscard]] Eigen::MatrixXd from_axis(const Eigen::MatrixXd& coefficients) const;

 private:
  [[nodiscard]] Eigen::MatrixXd about_z(const Eigen::MatrixXd& coefficients, double angle) const;
  [[nodiscard]] Eigen::MatrixXd about_y(const Eigen::MatrixXd& coefficients, bool back) const;

  HarmonicBasis basis_;
  MatrixProduct product_;
  double azimuth_, spin_;
  // By degree: of the cosines (rows and columns m = 0 to l) and of the sines (1 to l).
  struct Turn {
    Eigen::MatrixXd there, back;
  };
  std::vector<Turn> cosines_, sines_;
};

}  // namespace lamella
