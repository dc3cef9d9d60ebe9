#include "volume/adding/doubling.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volume/adding/modal_layer.h"
#include "volume/adding/thin_layer.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Optical depth, along the steepest node, of the layer that doubling starts from. In deep layers
// the start's error in the energy adds up, so that they start thinner.
double thin_start(double depth) { return depth > 10 ? 1.0 / 32768 : 1.0 / 256; }

// Whether nothing at all crosses: then more of the same behind it changes nothing.
bool is_opaque(const OperatorSide& side) {
  return side.direct_in.isZero(0) && side.direct_out.isZero(0) &&
         std::all_of(side.t.begin(), side.t.end(),
                     [](const MatrixXd& t) { return (t.array() == 0).all(); });
}

}  // namespace

LayerOperator doubled_layer(const LayerScattering& scattering, double depth,
                            const OperatorRules& rules) {
  const Index n = rules.sets.nodes();
  double steepest = 0;
  for (const VectorXd& area : scattering.sigma_in)
    steepest = std::max(steepest, area.head(n).cwiseQuotient(rules.sets.in.head(n)).maxCoeff());
  const bool infinite = std::isinf(depth);
  const double start = thin_start(depth);
  double thickness = infinite ? start / steepest : depth;
  int doublings = infinite ? 200 : 0;
  // In logarithms: the optical depth along the steepest node may be beyond all numbers.
  const double halvings = std::log2(depth) + std::log2(steepest) - std::log2(start);
  if (!infinite && halvings > 0) {
    doublings = static_cast<int>(std::ceil(halvings));
    thickness = std::ldexp(depth, -doublings);
  }
  LayerOperator layer = thin_layer(scattering, thickness, rules);
  for (int k = 0; k < doublings; ++k) {
    const MatrixXd before = layer.above.r[0].topLeftCorner(n, n);
    const OperatorSide& below = scattering.two_sided ? layer.above : layer.below;
    OperatorSide above = add_sides(layer.above, below, layer.above, rules);
    if (!scattering.two_sided)
      layer.below = add_sides(layer.below, layer.above, layer.below, rules);
    layer.above = std::move(above);
    thickness *= 2;
    set_direct(layer, scattering, thickness, rules.sets);
    if (is_opaque(layer.above) && (scattering.two_sided || is_opaque(layer.below))) break;
    if (!infinite) continue;
    // At albedo 1 what is missing falls like 1 / thickness only. In irradiance: between grazing
    // nodes f itself is large.
    const VectorXd root = rules.sets.flux.cwiseSqrt();
    const auto in_irradiance = [&](const MatrixXd& r) {
      return (root.asDiagonal() * r * root.asDiagonal()).cwiseAbs().maxCoeff();
    };
    const double change = in_irradiance(layer.above.r[0].topLeftCorner(n, n) - before);
    const bool opaque = layer.above.direct_in.head(n).maxCoeff() < 1e-17;
    if (opaque && change <= 1e-17 * in_irradiance(before)) break;
  }
  if (scattering.two_sided) layer.below = layer.above;
  if (infinite) {
    // What is still transmitted is lost to the depth: nothing where light comes back from it.
    layer.above.direct_in.setZero();
    layer.above.direct_out.setZero();
  }
  return layer;
}

LayerOperator homogeneous_layer(const LayerScattering& scattering, double depth,
                                const OperatorRules& rules) {
  if (rules.mode > 0 && scattering.two_sided) {
    const ModalLayer modal(scattering, rules.sets, depth, ModalLayer::Scope::all, rules.orders);
    if (auto layer = modal.layer(scattering, rules.mode, rules.product)) return std::move(*layer);
  }
  return doubled_layer(scattering, depth, rules);
}

}  // namespace lamella
