#pragma once

#include <Eigen/Core>
#include <functional>

namespace lamella {

struct GmresResult {
  Eigen::VectorXd solution;
  double residual = 0;  ///< over the right side
  int iterations = 0;
};

/// Solves (I - A) x = b by the generalised minimal residual method (Saad and Schultz 1986) without
/// restart: until the residual is below tolerance |b|, or for as many products with A.
[[nodiscard]] GmresResult solve_gmres(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& a, const Eigen::VectorXd& b,
    double tolerance, int max_iterations);

}  // namespace lamella
