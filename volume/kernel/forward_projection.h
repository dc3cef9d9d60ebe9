#pragma once

#include "volume/kernel/kernel_modes.h"
#include "volume/kernel/pair_modes.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {

/// Lagrange polynomials of the Gauss-Legendre points on (0, 1): value of the j-th (columns) at the
/// given points (rows), by the discrete orthogonality of the Legendre polynomials.
[[nodiscard]] Eigen::MatrixXd lagrange_values(const Quadrature& nodes,
                                              const Eigen::VectorXd& points);

/// Replaces the parts of a mirror medium's kernel that send light on (down to down, up to up).
/// There K jumps at w_o = -w_i, so that K_m has a kink at mu_o = mu_i and its values at the nodes
/// make a quadrature of second order only. With mu(u) and its slope s(u) (GrazingMap), radiance
/// times u is taken as a polynomial l_j(u) through the nodes, and the node values are replaced by
/// those that make the discrete sums exact for such radiance: Galerkin's moments, with v = s / u,
///   K_ij = integral of l_i(u) v(u) K v(u') l_j(u') du du' / (v_i g_i v_j g_j)
/// between nodes (g: weights in u; symmetric, so that reciprocity stays exact), and
///   K_oj = integral of K(mu_o, u') v(u') l_j(u') du' / (v_j g_j)
/// towards directions that are asked for, on both sides of the kink apart. Values between two
/// directions that are asked for stay.
template <class P>
void project_forward(const P& profile, double f0, const DirectionSets& sets, bool two_sided,
                     KernelModes& kernel) {
  using Eigen::ArrayXd;
  using Eigen::Index;
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  const int n = static_cast<int>(sets.nodes()), modes = static_cast<int>(kernel.modes.size());
  const Quadrature& nodes = cached_gauss_legendre(n);
  const Quadrature& fine = cached_gauss_legendre(n + n / 2 + 8);
  const Index q = fine.points.size();
  const auto v = [&](double u) { return sets.map.slope(u) / u; };
  const VectorXd scale = nodes.points.unaryExpr(v).cwiseProduct(nodes.weights).cwiseInverse();
  ArrayXd values(modes);
  const auto part_of = [&](int m, int part) -> MatrixXd& {
    return m < modes ? kernel.modes[m][part] : kernel.white[part];
  };
  // Modes, then the white mode 0, at points u' for a fixed direction; weights included.
  const auto row = [&](double mu, const VectorXd& u, const VectorXd& weight, bool mu_is_out) {
    MatrixXd samples(modes + 1, u.size());
    for (Index k = 0; k < u.size(); ++k) {
      const double other = sets.map.mu(u[k]);
      double white = 0;
      pair_modes(profile, f0, mu_is_out ? other : mu, mu_is_out ? -mu : -other, values, white);
      samples.col(k).head(modes) = weight[k] * values.matrix();
      samples(modes, k) = weight[k] * white;
    }
    return samples;
  };

  // Nodes to nodes, above to down; the square in two triangles, each by points u, u v.
  std::vector<MatrixXd> moments(modes + 1, MatrixXd::Zero(n, n));
  const MatrixXd outer = lagrange_values(nodes, fine.points);
  for (Index k = 0; k < q; ++k) {
    const double u = fine.points[k];
    const VectorXd inner = u * fine.points;
    const VectorXd weight =
        u * v(u) * fine.weights[k] * fine.weights.cwiseProduct(inner.unaryExpr(v));
    const MatrixXd lagrange = lagrange_values(nodes, inner);
    const double mu = sets.map.mu(u);
    const MatrixXd larger_in = row(mu, inner, weight, false) * lagrange;
    const MatrixXd larger_out =
        two_sided ? larger_in : MatrixXd(row(mu, inner, weight, true) * lagrange);
    for (int m = 0; m <= modes; ++m) {
      moments[m].noalias() += larger_in.row(m).transpose() * outer.row(k);
      moments[m].noalias() += outer.row(k).transpose() * larger_out.row(m);
    }
  }
  for (int m = 0; m <= modes; ++m)
    part_of(m, kAboveToDown).topLeftCorner(n, n) =
        scale.asDiagonal() * moments[m] * scale.asDiagonal();

  // Nodes and directions that are asked for.
  const auto asked = [&](double mu, bool mu_is_out) {
    const double u = sets.map.parameter(mu);
    VectorXd points(2 * q), weight(2 * q);
    points << u * fine.points, u + (1 - u) * fine.points.array();
    weight << u * fine.weights, (1 - u) * fine.weights;
    weight = weight.cwiseProduct(points.unaryExpr(v));
    return MatrixXd(row(mu, points, weight, mu_is_out) * lagrange_values(nodes, points) *
                    scale.asDiagonal());
  };
  for (Index i = n; i < sets.out.size(); ++i) {
    const MatrixXd down = asked(sets.out[i], true);
    for (int m = 0; m <= modes; ++m) part_of(m, kAboveToDown).row(i).head(n) = down.row(m);
    // K is symmetric: from below to an upward o is from o, above, to a downward node.
    const MatrixXd up = two_sided ? down : asked(sets.out[i], false);
    for (int m = 0; m <= modes; ++m) part_of(m, kBelowToUp).row(i).head(n) = up.row(m);
  }
  for (Index j = n; j < sets.in.size(); ++j) {
    const MatrixXd above = asked(sets.in[j], false);
    for (int m = 0; m <= modes; ++m)
      part_of(m, kAboveToDown).col(j).head(n) = above.row(m).transpose();
    const MatrixXd below = two_sided ? above : asked(sets.in[j], true);
    for (int m = 0; m <= modes; ++m)
      part_of(m, kBelowToUp).col(j).head(n) = below.row(m).transpose();
  }
  for (int m = 0; m <= modes; ++m)
    part_of(m, kBelowToUp).topLeftCorner(n, n) =
        part_of(m, kAboveToDown).topLeftCorner(n, n).transpose();
}

}  // namespace lamella
