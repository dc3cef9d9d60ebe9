#include "volume/adding/without_subtraction.h"

namespace lamella {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

WithoutSubtraction::WithoutSubtraction(const MatrixXd& product, const Eigen::RowVectorXd& defect)
    : a_(product.transpose()), pivot_(product.rows()) {
  // Row sums of I - a are the defect.
  const Index n = a_.rows();
  VectorXd v = defect.transpose();
  for (Index k = 0; k < n; ++k) {
    const Index rest = n - k - 1;
    pivot_[k] = v[k] + a_.row(k).tail(rest).sum();
    if (rest == 0) break;
    const VectorXd column = pivot_[k] == 0 ? VectorXd(VectorXd::Zero(rest))
                                           : VectorXd(a_.col(k).tail(rest) / pivot_[k]);
    a_.bottomRightCorner(rest, rest).noalias() += column * a_.row(k).tail(rest);
    v.tail(rest) += column * v[k];
    a_.col(k).tail(rest) = column;
  }
}

// I - a = L U with L = I - (columns below), U = pivots - (rows right); this solves U^T L^T D = B.
MatrixXd WithoutSubtraction::solve(MatrixXd b) const {
  const Index n = a_.rows();
  for (Index k = 0; k < n; ++k) {
    if (pivot_[k] == 0)
      b.row(k).setZero();
    else
      b.row(k) /= pivot_[k];
    const Index rest = n - k - 1;
    if (rest > 0) b.bottomRows(rest).noalias() += a_.row(k).tail(rest).transpose() * b.row(k);
  }
  for (Index k = n - 1; k >= 0; --k) {
    const Index rest = n - k - 1;
    if (rest > 0) b.row(k).noalias() += a_.col(k).tail(rest).transpose() * b.bottomRows(rest);
  }
  return b;
}

}  // namespace lamella
