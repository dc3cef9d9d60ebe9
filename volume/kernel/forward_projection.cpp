#include "volume/kernel/forward_projection.h"

namespace lamella {

Eigen::MatrixXd lagrange_values(const Quadrature& nodes, const Eigen::VectorXd& points) {
  const Eigen::Index n = nodes.points.size();
  const auto legendre = [&](const Eigen::VectorXd& at) {
    Eigen::MatrixXd p(at.size(), n);
    const Eigen::ArrayXd x = 2 * at.array() - 1;
    p.col(0).setOnes();
    if (n > 1) p.col(1) = x;
    for (Eigen::Index l = 2; l < n; ++l) {
      const double order = static_cast<double>(l);
      p.col(l) =
          ((2 * order - 1) * x * p.col(l - 1).array() - (order - 1) * p.col(l - 2).array()) / order;
    }
    return p;
  };
  const Eigen::MatrixXd at_nodes = legendre(nodes.points);
  const Eigen::VectorXd norm =
      Eigen::VectorXd::LinSpaced(n, 1, 2 * static_cast<double>(n) - 1);  // 2 l + 1
  return legendre(points) * norm.asDiagonal() * at_nodes.transpose() * nodes.weights.asDiagonal();
}

}  // namespace lamella
