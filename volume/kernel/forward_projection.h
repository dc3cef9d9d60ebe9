#pragma once

#include <oneapi/tbb/parallel_for.h>

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
/// make a quadrature of second order only. With mu(u) and its slope s(u) (NodePanel), u times the
/// radiance is taken as a polynomial through the nodes, with Lagrange polynomials l_j(u). The node
/// values are replaced by those that make the discrete sums exact for that polynomial: Galerkin's
/// moments, with v = s / u,
///   K_ij = integral of l_i(u) v(u) K v(u') l_j(u') du du' / (v_i g_i v_j g_j)
/// between nodes (g: weights in u; symmetric, so that reciprocity stays exact), and
///   K_oj = integral of K(mu_o, u') v(u') l_j(u') du' / (v_j g_j)
/// towards directions that are asked for, on both sides of the kink apart. Values between two
/// directions that are asked for stay.
template <class P>
void project_forward(const P& profile, double f0, const DirectionSets& sets, bool two_sided,
                     const MatrixProduct& product, KernelModes& kernel) {
  using Eigen::Index;
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  const Index n = sets.nodes();
  const int modes = static_cast<int>(kernel.modes.size());
  // A panel's own rule and a finer one, with the factors that turn moments into node values.
  struct Rules {
    const NodePanel* panel;
    const Quadrature* nodes;
    const Quadrature* fine;
    VectorXd scale;
    MatrixXd outer;
    [[nodiscard]] double v(double u) const { return panel->slope(u) / u; }
  };
  std::vector<Rules> rules;
  for (const NodePanel& panel : sets.panels) {
    const int count = static_cast<int>(panel.count);
    Rules r{&panel, &cached_gauss_legendre(count), &cached_gauss_legendre(count + count / 2 + 8),
            VectorXd(), MatrixXd()};
    r.scale = r.nodes->points.unaryExpr([&](double u) { return r.v(u); })
                  .cwiseProduct(r.nodes->weights)
                  .cwiseInverse();
    r.outer = lagrange_values(*r.nodes, r.fine->points);
    rules.push_back(std::move(r));
  }
  const auto part_of = [&](int m, int part) -> MatrixXd& {
    return m < modes ? kernel.modes[m][part] : kernel.white[part];
  };
  // Modes, then the white mode 0, at points u' for a fixed direction; weights included.
  const auto row = [&](const NodePanel& panel, double mu, const VectorXd& u, const VectorXd& weight,
                       bool mu_is_out) {
    std::vector<CosinePair> pairs;
    for (const double at : u) {
      const double other = panel.mu(at);
      pairs.push_back(mu_is_out ? CosinePair{other, -mu} : CosinePair{mu, -other});
    }
    MatrixXd samples = many_pair_modes(profile, f0, pairs, modes, product);
    samples *= weight.asDiagonal();
    return samples;
  };

  // Nodes to nodes, above to down, within one panel: the square in two triangles, each by points
  // u, u v.
  const auto within = [&](const Rules& r) {
    const NodePanel& panel = *r.panel;
    std::vector<MatrixXd> moments(modes + 1, MatrixXd::Zero(panel.count, panel.count));
    for (Index k = 0; k < r.fine->points.size(); ++k) {
      const double u = r.fine->points[k];
      const VectorXd inner = u * r.fine->points;
      const VectorXd weight =
          u * r.v(u) * r.fine->weights[k] *
          r.fine->weights.cwiseProduct(inner.unaryExpr([&](double w) { return r.v(w); }));
      const MatrixXd lagrange = lagrange_values(*r.nodes, inner);
      const double mu = panel.mu(u);
      const MatrixXd larger_in = product(row(panel, mu, inner, weight, false), lagrange);
      const MatrixXd larger_out =
          two_sided ? larger_in : product(row(panel, mu, inner, weight, true), lagrange);
      for (int m = 0; m <= modes; ++m) {
        moments[m].noalias() += larger_in.row(m).transpose() * r.outer.row(k);
        moments[m].noalias() += r.outer.row(k).transpose() * larger_out.row(m);
      }
    }
    return moments;
  };
  // From one panel to another, whose corner alone meets the kink.
  const auto between = [&](const Rules& to, const Rules& from) {
    std::vector<MatrixXd> moments(modes + 1, MatrixXd::Zero(to.panel->count, from.panel->count));
    const VectorXd weight =
        to.fine->weights.cwiseProduct(to.fine->points.unaryExpr([&](double u) { return to.v(u); }));
    for (Index k = 0; k < from.fine->points.size(); ++k) {
      const double u = from.fine->points[k];
      const MatrixXd sent = from.v(u) * from.fine->weights[k] *
                            row(*to.panel, from.panel->mu(u), to.fine->points, weight, false) *
                            to.outer;
      for (int m = 0; m <= modes; ++m)
        moments[m].noalias() += sent.row(m).transpose() * from.outer.row(k);
    }
    return moments;
  };
  for (const Rules& to : rules)
    for (const Rules& from : rules) {
      const std::vector<MatrixXd> moments = &to == &from ? within(to) : between(to, from);
      for (int m = 0; m <= modes; ++m)
        part_of(m, kAboveToDown)
            .block(to.panel->first, from.panel->first, to.panel->count, from.panel->count) =
            to.scale.asDiagonal() * moments[m] * from.scale.asDiagonal();
    }

  // Nodes and directions that are asked for.
  const auto asked = [&](double mu, bool mu_is_out) {
    MatrixXd result(modes + 1, n);
    for (const Rules& r : rules) {
      const double u = r.panel->parameter(mu);
      const Index q = r.fine->points.size();
      VectorXd points(2 * q), weight(2 * q);
      points << u * r.fine->points, u + (1 - u) * r.fine->points.array();
      weight << u * r.fine->weights, (1 - u) * r.fine->weights;
      if (rules.size() > 1 && (u == 0 || u == 1)) {
        points = r.fine->points;
        weight = r.fine->weights;
      }
      weight = weight.cwiseProduct(points.unaryExpr([&](double w) { return r.v(w); }));
      result.middleCols(r.panel->first, r.panel->count) =
          product(row(*r.panel, mu, points, weight, mu_is_out), lagrange_values(*r.nodes, points)) *
          r.scale.asDiagonal();
    }
    return result;
  };
  oneapi::tbb::parallel_for(n, sets.out.size(), [&](Index i) {
    const MatrixXd down = asked(sets.out[i], true);
    for (int m = 0; m <= modes; ++m) part_of(m, kAboveToDown).row(i).head(n) = down.row(m);
    // K is symmetric: from below to an upward o is from o, above, to a downward node.
    const MatrixXd up = two_sided ? down : asked(sets.out[i], false);
    for (int m = 0; m <= modes; ++m) part_of(m, kBelowToUp).row(i).head(n) = up.row(m);
  });
  oneapi::tbb::parallel_for(n, sets.in.size(), [&](Index j) {
    const MatrixXd above = asked(sets.in[j], false);
    for (int m = 0; m <= modes; ++m)
      part_of(m, kAboveToDown).col(j).head(n) = above.row(m).transpose();
    const MatrixXd below = two_sided ? above : asked(sets.in[j], true);
    for (int m = 0; m <= modes; ++m)
      part_of(m, kBelowToUp).col(j).head(n) = below.row(m).transpose();
  });
  for (int m = 0; m <= modes; ++m)
    part_of(m, kBelowToUp).topLeftCorner(n, n) =
        part_of(m, kAboveToDown).topLeftCorner(n, n).transpose();
}

}  // namespace lamella
