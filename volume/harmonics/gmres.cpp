#include "volume/harmonics/gmres.h"

#include <cmath>
#include <vector>

namespace lamella {

using Eigen::MatrixXd;
using Eigen::VectorXd;

GmresResult solve_gmres(const std::function<VectorXd(const VectorXd&)>& a, const VectorXd& b,
                        double tolerance, int max_iterations) {
  GmresResult result{VectorXd::Zero(b.size()), 0, 0};
  const double size = b.norm();
  if (!(size > 0)) return result;
  std::vector<VectorXd> basis{b / size};
  MatrixXd triangle = MatrixXd::Zero(max_iterations, max_iterations);
  VectorXd right = VectorXd::Zero(max_iterations + 1), cosines(max_iterations),
           sines(max_iterations);
  right[0] = size;
  int n = 0;
  result.residual = 1;
  while (n < max_iterations && result.residual > tolerance) {
    VectorXd next = basis[n] - a(basis[n]);
    VectorXd column = VectorXd::Zero(n + 1);
    // Twice: once loses orthogonality to rounding.
    for (int pass = 0; pass < 2; ++pass)
      for (int k = 0; k <= n; ++k) {
        const double part = basis[k].dot(next);
        column[k] += part;
        next -= part * basis[k];
      }
    const double rest = next.norm();
    for (int k = 0; k < n; ++k) {
      const double x = column[k], y = column[k + 1];
      column[k] = cosines[k] * x + sines[k] * y;
      column[k + 1] = cosines[k] * y - sines[k] * x;
    }
    const double length = std::hypot(column[n], rest);
    cosines[n] = length > 0 ? column[n] / length : 1;
    sines[n] = length > 0 ? rest / length : 0;
    column[n] = length;
    triangle.col(n).head(n + 1) = column;
    right[n + 1] = -sines[n] * right[n];
    right[n] *= cosines[n];
    ++n;
    result.residual = std::abs(right[n]) / size;
    if (!(rest > 1e-300)) break;
    basis.push_back(next / rest);
  }
  const VectorXd y =
      triangle.topLeftCorner(n, n).triangularView<Eigen::Upper>().solve(right.head(n));
  for (int k = 0; k < n; ++k) result.solution += y[k] * basis[k];
  result.iterations = n;
  return result;
}

}  // namespace lamella
