#include "volume/harmonics/wigner.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace lamella {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// d^j_jn, of which every first value is one up to signs: sqrt(binomial(2 j, j + n)) c^(j + n)
// s^(j - n). The root is 1e58 at the most up to degree 192, so that powers underflow only where the
// whole is below 1e-240.
ArrayXd top_row(int j, int n, const ArrayXd& cosines, const ArrayXd& sines) {
  double root = 1;
  const int fewer = std::min(j + n, j - n);
  for (int k = 1; k <= fewer; ++k) root *= std::sqrt((2.0 * j - fewer + k) / k);
  return root * cosines.pow(j + n) * sines.pow(j - n);
}

// Of l = max(|m|, |n|), by d_mn = (-1)^(m - n) d_nm = d_(-n)(-m).
ArrayXd first_values(int m, int n, const Eigen::Ref<const VectorXd>& angles) {
  const int l = std::max(std::abs(m), std::abs(n));
  const ArrayXd cosines = (angles.array() / 2).cos(), sines = -(angles.array() / 2).sin();
  if (m == l) return top_row(l, n, cosines, sines);
  if (-n == l) return top_row(l, -m, cosines, sines);
  const double sign = (m - n) % 2 == 0 ? 1 : -1;
  return sign * (n == l ? top_row(l, m, cosines, sines) : top_row(l, -n, cosines, sines));
}

}  // namespace

MatrixXd wigner_rows(int m, int n, const Eigen::Ref<const VectorXd>& angles, int degree) {
  const int start = std::max(std::abs(m), std::abs(n));
  if (start > degree) return MatrixXd(angles.size(), 0);
  MatrixXd rows(angles.size(), degree - start + 1);
  rows.col(0) = first_values(m, n, angles);
  const ArrayXd cosine = angles.array().cos();
  const double mm = m, nn = n;
  for (int l = start; l < degree; ++l) {
    const int k = l - start;
    // At l = 0 the recurrence divides nothing by nothing: d^1_00 is the cosine.
    if (l == 0) {
      rows.col(1) = cosine;
      continue;
    }
    const double ll = l, next_l = l + 1;
    const double up = ll * std::sqrt((next_l * next_l - mm * mm) * (next_l * next_l - nn * nn));
    const double down = next_l * std::sqrt((ll * ll - mm * mm) * (ll * ll - nn * nn)) / up;
    const double slope = (2 * ll + 1) * ll * next_l / up, shift = (2 * ll + 1) * mm * nn / up;
    rows.col(k + 1) = (slope * cosine - shift) * rows.col(k).array();
    if (k > 0) rows.col(k + 1) -= down * rows.col(k - 1);
  }
  return rows;
}

void wigner_d(int m, int n, double angle, Eigen::Ref<VectorXd> values) {
  const int degree = static_cast<int>(values.size()) - 1;
  const MatrixXd row = wigner_rows(m, n, VectorXd::Constant(1, angle), degree);
  values.setZero();
  values.tail(row.cols()) = row.transpose();
}

}  // namespace lamella
