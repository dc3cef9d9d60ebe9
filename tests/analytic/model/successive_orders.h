#pragma once

#include <Eigen/Dense>
#include <functional>
#include <vector>

#include "analytic/half_space/three_term.h"

namespace lamella::testing {

/// The coefficient of cos(m phi) of a phase function times its albedo [1/sr] at cos Theta = x y +
/// sqrt(1 - x^2) sqrt(1 - y^2) cos phi, x and y in [-1, 1].
using FourierKernel = std::function<double(int m, double x, double y)>;

/// The kernel of three Legendre terms, and of the Lambertian sphere itself (trapezoidal rule).
[[nodiscard]] FourierKernel three_term_kernel(const ThreeTermPhase& w);
[[nodiscard]] FourierKernel lambert_sphere_kernel(double albedo);

/// Reflection of a half space order by order, at pairs of nodes: an independent check that uses
/// neither H functions nor the form of the solution. With S / (x y) = T, the principle
/// of invariance splits by order into
///   (x + y) T_n = p(x, -y) [n = 1] + x / 2 int T_(n-1)(x, z) p(z, y) dz
///     + y / 2 int p(x, z) T_(n-1)(z, y) dz
///     + x y / 4 sum over j + k = n - 1 of iint T_j(x, z) p(-z, z') T_k(z', y) dz dz'
/// with p the m-th azimuthal mode. The nodes are Gauss's in z^(1/3), because T is like z log z.
class SuccessiveOrders {
 public:
  SuccessiveOrders(const FourierKernel& kernel, int m, int orders);

  [[nodiscard]] const std::vector<double>& nodes() const { return z_; }
  /// Coefficient of cos(m phi) of f_n at a pair of nodes.
  [[nodiscard]] double order(int n, int i, int j) const { return scale_ * t_[n - 1](i, j); }
  /// The sum over all orders computed, from `first` on.
  [[nodiscard]] double sum(int i, int j, int first = 1) const;

 private:
  double scale_;
  std::vector<double> z_;
  std::vector<Eigen::MatrixXd> t_;
};

}  // namespace lamella::testing
