#include "volume/harmonics/harmonic_turn.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "volume/harmonics/wigner.h"

namespace lamella {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The axis is z turned about y by its polar angle, then about z by its azimuth. In terms of
// Wigner's d the turn about y maps
//   cosine m to cosine n: (-1)^n ((-1)^m d_mn + d_(-m)n), sqrt(2) (-1)^(m + n) d_mn where m or n
//   is 0 and the other is not, d_00; sine m to sine n: (-1)^n ((-1)^m d_mn - d_(-m)n).
HarmonicTurn::HarmonicTurn(const HarmonicBasis& basis, Direction axis, MatrixProduct product,
                           double spin)
    : basis_(basis), product_(product), azimuth_(std::atan2(axis.y, axis.x)), spin_(spin) {
  const int degree = basis.degree();
  const double angle = std::atan2(std::hypot(axis.x, axis.y), axis.z);
  for (int l = 0; l <= degree; ++l) {
    cosines_.push_back({MatrixXd(l + 1, l + 1), {}});
    sines_.push_back({MatrixXd(l, l), {}});
  }
  tbb::parallel_for(0, degree + 1, [&](int m) {
    VectorXd plus(degree + 1), minus(degree + 1);
    for (int n = 0; n <= degree; ++n) {
      wigner_d(m, n, angle, plus);
      wigner_d(-m, n, angle, minus);
      const double sign_m = m % 2 ? -1 : 1, sign_n = n % 2 ? -1 : 1;
      for (int l = std::max(m, n); l <= degree; ++l) {
        double& cosine = cosines_[l].there(n, m);
        if (m == 0 && n == 0)
          cosine = plus[l];
        else if (m == 0 || n == 0)
          cosine = std::sqrt(2.0) * sign_m * sign_n * plus[l];
        else
          cosine = sign_n * (sign_m * plus[l] + minus[l]);
        if (m > 0 && n > 0) sines_[l].there(n - 1, m - 1) = sign_n * (sign_m * plus[l] - minus[l]);
      }
    }
  });
  for (std::vector<Turn>* turns : {&cosines_, &sines_})
    for (Turn& turn : *turns) turn.back = turn.there.transpose();
}

MatrixXd HarmonicTurn::about_z(const MatrixXd& coefficients, double angle) const {
  MatrixXd turned = coefficients;
  for (int m = 1; m <= basis_.degree(); ++m) {
    const double c = std::cos(m * angle), s = std::sin(m * angle);
    const auto cosine = coefficients.middleRows(basis_.first(m, false), basis_.count(m));
    if (basis_.is_even()) {
      turned.middleRows(basis_.first(m, false), basis_.count(m)) = c * cosine;
      continue;
    }
    const auto sine = coefficients.middleRows(basis_.first(m, true), basis_.count(m));
    turned.middleRows(basis_.first(m, false), basis_.count(m)) = c * cosine + s * sine;
    turned.middleRows(basis_.first(m, true), basis_.count(m)) = c * sine - s * cosine;
  }
  return turned;
}

MatrixXd HarmonicTurn::about_y(const MatrixXd& coefficients, bool back) const {
  MatrixXd turned(coefficients.rows(), coefficients.cols());
  tbb::parallel_for(0, basis_.degree() + 1, [&](int l) {
    for (const bool sine : {false, true}) {
      if (sine && basis_.is_even()) continue;
      const Turn& both = sine ? sines_[l] : cosines_[l];
      const MatrixXd& turn = back ? both.back : both.there;
      if (turn.size() == 0) continue;
      const int lowest = sine ? 1 : 0;
      MatrixXd rows(turn.rows(), coefficients.cols());
      for (int m = lowest; m <= l; ++m)
        rows.row(m - lowest) = coefficients.row(basis_.place(l, m, sine));
      const MatrixXd product = product_(turn, rows);
      for (int m = lowest; m <= l; ++m)
        turned.row(basis_.place(l, m, sine)) = product.row(m - lowest);
    }
  });
  return turned;
}

MatrixXd HarmonicTurn::to_axis(const MatrixXd& coefficients) const {
  const MatrixXd turned = about_y(about_z(coefficients, azimuth_), false);
  return spin_ == 0 ? turned : about_z(turned, spin_);
}

MatrixXd HarmonicTurn::from_axis(const MatrixXd& coefficients) const {
  if (spin_ == 0) return about_z(about_y(coefficients, true), -azimuth_);
  return about_z(about_y(about_z(coefficients, -spin_), true), -azimuth_);
}

}  // namespace lamella
