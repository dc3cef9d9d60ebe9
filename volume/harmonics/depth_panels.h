#pragma once

#include <Eigen/Core>
#include <vector>

namespace lamella {

/// Panels in the depth of one homogeneous layer, thin at both of its boundaries, where the source
/// function behaves like z log z, and the nodes of Gauss and Legendre in each of them.
class DepthPanels {
 public:
  /// depth: finite; scale: optical depth per depth, of the direction that sees the flakes best;
  /// finest: depth over which light that grazes changes.
  DepthPanels(double depth, double scale, double finest, int nodes);

  [[nodiscard]] int nodes() const { return nodes_; }  ///< of a panel
  [[nodiscard]] int panels() const { return static_cast<int>(kind_.size()); }
  [[nodiscard]] int size() const { return nodes_ * panels(); }
  [[nodiscard]] double depth() const { return depth_; }
  [[nodiscard]] double place(int node) const { return place_[node]; }    ///< below the layer's top
  [[nodiscard]] double weight(int node) const { return weight_[node]; }  ///< for integrals
  /// Panels of one length share what depends on it: which of them, and the first of each kind.
  [[nodiscard]] int kind(int panel) const { return kind_[panel]; }
  [[nodiscard]] const std::vector<double>& kinds() const { return kinds_; }

 private:
  int nodes_;
  double depth_;
  std::vector<double> place_, weight_, kinds_;
  std::vector<int> kind_;
};

/// How a beam gathers a source that is a polynomial through a panel's nodes, and is attenuated: in
/// units of the panel's length, along the way of the light.
class PanelIntegrals {
 public:
  explicit PanelIntegrals(int nodes);

  [[nodiscard]] int nodes() const { return nodes_; }
  /// x >= 0: the optical depth of the panel along the way. `gather`, nodes x nodes: integral from
  /// the beginning to node i of exp(-x (t_i - t)) times the polynomial that is 1 at node j.
  /// `leave`: the same to the end. `pass`: exp(-x t_i). All to 1e-12. `gather` may be null, and
  /// `pass` with it.
  void at(double x, double* gather, double* leave, double* pass) const;

 private:
  // phi_k(y), the integral of exp(-y (1 - s)) s^k over s in (0, 1), k < nodes.
  void moments(double y, double* phi) const;

  int nodes_;
  Eigen::VectorXd points_;  // t_i, and 1 as the last
  // By i: coefficients of the polynomials l_j(t_i s) in powers of s, times t_i.
  std::vector<Eigen::MatrixXd> powers_;
  // By i: l_j(t_i s_q) w_q t_i for the rule that serves small x.
  std::vector<Eigen::MatrixXd> values_;
};

}  // namespace lamella
