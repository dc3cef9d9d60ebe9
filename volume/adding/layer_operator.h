#pragma once

#include <Eigen/Core>
#include <array>

#include "volume/algebra/matrix_product.h"
#include "volume/kernel/layer_scattering.h"

namespace lamella {

/// Scattering orders that are kept apart: 1, 2, 3; index 0 is their sum with all higher ones.
inline constexpr int kSeries = 4;
using Series = std::array<Eigen::MatrixXd, kSeries>;

/// What a pile of layers does, in one azimuthal mode, to light that arrives from one side. r and t
/// are modes of the BSDF [1/sr], rows: outgoing directions, columns: incoming ones. Light that
/// meets nothing is apart.
struct OperatorSide {
  Series r, t;
  Eigen::VectorXd direct_in;    ///< share of a beam along `in` that crosses without a collision
  Eigen::VectorXd direct_out;   ///< the same for the directions of `out`, light from this side
  Eigen::RowVectorXd absorbed;  ///< share of a beam that is absorbed (mode 0 only)
};

/// Both sides: light from above and from below.
struct LayerOperator {
  OperatorSide above, below;
};

/// How operators are combined.
struct OperatorRules {
  const DirectionSets& sets;
  int mode = 0;
  int orders = 3;  ///< 1, 2, ... of the orders 1 to 3 that are followed
  MatrixProduct product{};
};

/// One side of `near` over `far`: light that arrives at the front of `near`, whose back faces the
/// front of `far`.
[[nodiscard]] OperatorSide add_sides(const OperatorSide& near_front, const OperatorSide& near_back,
                                     const OperatorSide& far_front, const OperatorRules& rules);

/// Top over bottom. Multiple reflections between them are summed by (I - R R)^-1: in mode 0 by an
/// elimination without subtractions (Grassmann, Taksar and Heyman 1985), fed with what is
/// transmitted and absorbed instead of with 1 - R R, so that every entry keeps its relative
/// accuracy at albedo 1 and any depth.
[[nodiscard]] LayerOperator add_layers(const LayerOperator& top, const LayerOperator& bottom,
                                       const OperatorRules& rules);

/// No layer at all: everything crosses.
[[nodiscard]] LayerOperator empty_layer(const OperatorRules& rules);

/// A Lambertian surface that transmits nothing.
[[nodiscard]] LayerOperator lambert_substrate(double albedo, const OperatorRules& rules);

}  // namespace lamella
