#pragma once

#include <Eigen/Core>

namespace lamella {

/// Wigner's d^l_mn(angle) of a turn about y, for one pair m, n and every l from max(|m|, |n|) to
/// the degree: values[l]; below that 0. By the recurrence in l, that of Jacobi's polynomials;
/// absolute error below 1e-11 up to degree 192. Convention: d^1_10 = -sin(angle) / sqrt(2).
void wigner_d(int m, int n, double angle, Eigen::Ref<Eigen::VectorXd> values);

/// The same at some angles: rows are angles, columns l from max(|m|, |n|) to the degree.
[[nodiscard]] Eigen::MatrixXd wigner_rows(int m, int n,
                                          const Eigen::Ref<const Eigen::VectorXd>& angles,
                                          int degree);

}  // namespace lamella
