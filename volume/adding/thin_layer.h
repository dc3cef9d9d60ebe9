#pragma once

#include "volume/adding/layer_operator.h"

namespace lamella {

/// A layer that light along the nodes crosses almost undisturbed, from its orders 1 and 2.
/// Order 1 is exact. Order 2 sums over the nodes the chains w_i -> node -> w_o with the exact
/// integrals over the two depths, but for exp(-x) along the inner segment of optical depth x, which
/// is replaced by its mean (1 - exp(-y)) / y, y = 2/3 of the node's optical depth (right to first
/// order). thickness times sigma / mu of every node should be well below 1; of the directions
/// that are asked for it may be anything, infinity included.
[[nodiscard]] LayerOperator thin_layer(const LayerScattering& scattering, double thickness,
                                       const OperatorRules& rules);

/// Sets the uncollided shares of a homogeneous layer afresh, so that no error accumulates.
void set_direct(LayerOperator& layer, const LayerScattering& scattering, double thickness,
                const DirectionSets& sets);

}  // namespace lamella
