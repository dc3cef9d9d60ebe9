#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/adding/modal_flights.h"

namespace lamella {

/// Order 3 of a homogeneous layer that is the same from both sides: light of order 1 at the depth
/// t, the kernel between nodes, and what order 1 of the reversed way sends out from there,
/// integrated over t by the trapezoidal rule in x, t = T / (1 + exp(-x)), or exp(x) in a half
/// space. The integrand is analytic for |Im x| < pi / 2: the error is below 1e-9 of order 3. Tables
/// serve all modes; several modes may be asked for at once.
class ThirdOrder {
 public:
  /// keeps_tables: for many modes; else each of them makes its own, a node's at a time.
  ThirdOrder(const LayerScattering& scattering, const DirectionSets& sets, double depth,
             const LayerDirections& out, const LayerDirections& in, bool keeps_tables);
  /// on_out, back_out: the kernel between directions of `out` (rows) and nodes; on_in, back_in:
  /// between directions of `in` (rows) and nodes.
  [[nodiscard]] Lobes lobes(const Parts& kernel, const Eigen::MatrixXd& on_out,
                            const Eigen::MatrixXd& back_out, const Eigen::MatrixXd& on_in,
                            const Eigen::MatrixXd& back_in, const MatrixProduct& product) const;

 private:
  // Directions with what a beam along them has left at each depth below the front and above the
  // back: [direction, depth].
  struct Beams {
    Eigen::VectorXd mu, sigma;
    Eigen::ArrayXXd from_front, from_back;
  };
  // Light of order 1 per kernel, by depth: the same way as the beam, and the other way.
  struct Light {
    Eigen::MatrixXd same, other;
  };
  [[nodiscard]] Beams beams(const Eigen::VectorXd& mu, const Eigen::VectorXd& sigma) const;
  // At node k, of beams along all directions (rows). used: memory to use again.
  [[nodiscard]] Light light(Eigen::Index k, const Beams& directions, Light used = {}) const;

  Eigen::VectorXd root_;  // D
  Eigen::ArrayXd t_, rest_;
  Eigen::VectorXd weights_;
  bool infinite_;
  Beams nodes_, out_, in_;
  std::vector<Light> kept_in_, kept_out_;  // by node
};

}  // namespace lamella
