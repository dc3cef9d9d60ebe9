#include "volume/algebra/matrix_product.h"

#include <array>

#include "volume/algebra/matrix_product_task.h"

namespace lamella {

using Eigen::MatrixXd;

void MatrixProduct::add(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b,
                        Eigen::Ref<MatrixXd> c) const {
  const auto multiply_add = multiply_add_lanes_for(isa_);
  if (!multiply_add) {
    c.noalias() += a * b;
    return;
  }
  if (c.size() == 0 || a.cols() == 0) return;
  alignas(64) thread_local std::array<double, kProductScratch> scratch;
  multiply_add({a.data(), a.outerStride(), b.data(), b.outerStride(), c.data(), c.outerStride(),
                c.rows(), c.cols(), a.cols(), scratch.data()});
}

MatrixXd MatrixProduct::operator()(const Eigen::Ref<const MatrixXd>& a,
                                   const Eigen::Ref<const MatrixXd>& b) const {
  MatrixXd c = MatrixXd::Zero(a.rows(), b.cols());
  add(a, b, c);
  return c;
}

}  // namespace lamella
