#pragma once

#include <Eigen/Core>
#include <array>

#include "volume/adding/layer_operator.h"
#include "volume/algebra/matrix_product.h"

namespace lamella {

/// What is kept apart of light that boundaries take part in: [0] everything together, [1] to [3]
/// the orders 1 to 3, [4] order 0, which has met boundaries alone.
inline constexpr int kPileSeries = 5;
inline constexpr int kOrderZero = 4;
/// Matrices like OperatorSide's; empty: nothing.
using PileSeries = std::array<Eigen::MatrixXd, kPileSeries>;
/// Shares of beams; empty: nothing.
using BeamSeries = std::array<Eigen::VectorXd, kPileSeries>;

/// What becomes of beams along a list of directions that arrive at a pile from one side: shares of
/// their energy that stay beams, straight on by Snell's law or back along the mirror image.
struct BeamShares {
  BeamSeries mirror;
  Eigen::VectorXd direct;  ///< of order 0; empty: nothing crosses
  /// What is left beside mirror and direct, of order 0 and of all orders: known without
  /// cancellation, as a mirror may be almost total.
  Eigen::VectorXd met, gone;
};

/// What a pile of layers and boundaries does, in one azimuthal mode, to light that arrives from one
/// side: the BSDF r and t [1/sr] as in OperatorSide, and the ways of beams. `out` holds the shares
/// of light along the directions of `out`, whose radiance changes by n^2 besides.
struct PileSide {
  PileSeries r, t;
  BeamShares in, out;
  Eigen::RowVectorXd absorbed, lost;  ///< mode 0 only
};

/// Both sides. The directions above the pile and below it may differ: each has its own medium.
struct PileOperator {
  const DirectionSets* top = nullptr;
  const DirectionSets* bottom = nullptr;
  PileSide above, below;
  bool is_open = true;  ///< else light from below has no meaning, and `below` is empty
};

/// How piles are combined.
struct PileRules {
  int mode = 0;
  int orders = 3;  ///< 1, 2, ... of the orders 1 to 3 that are followed
  MatrixProduct product{};
};

/// A layer, whose operator add_layers could take as well. sigma_in: projected areas as in
/// LayerScattering; depth: of the layer.
[[nodiscard]] PileOperator pile_of(LayerOperator layer, const LayerScattering& scattering,
                                   double depth, const DirectionSets& sets);

/// Top over bottom, where top is open. The sum over all orders of what goes to and fro is made as
/// in add_layers, without subtractions in mode 0; beams are summed apart, index by index.
[[nodiscard]] PileOperator add_piles(const PileOperator& top, const PileOperator& bottom,
                                     const PileRules& rules);

}  // namespace lamella
