#include "volume/interfaces/boundary_stack.h"

namespace lamella {
namespace {

std::array<double, 3> channels(Rgb c) { return {c.r, c.g, c.b}; }

const Medium& no_medium() {
  static const Medium medium = HenyeyGreenstein{0};
  return medium;
}

}  // namespace

BoundaryStack::BoundaryStack(const Stack& stack, const Plan& plan)
    : boundaries(1),
      has_substrate(stack.substrate.has_value()),
      max_order(plan.max_order),
      thinning(plan.thinning) {
  double index = 1;
  const auto add_layer = [&](const WalkLayer& layer, int source) {
    layers.push_back(layer);
    sources.push_back(source);
    boundaries.emplace_back();
  };
  const WalkLayer gap{&no_medium(), 0, {1, 1, 1}, {1, 1, 1}, false};
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    if (const auto& interface = layer.interface) {
      if (interface->ior == index) continue;  // changes nothing, rough or not
      if (boundaries.back()) add_layer(gap, -1);
      boundaries.back() = Dielectric{.facets = interface->facets,
                                     .masking = interface->masking,
                                     .multiple = interface->multiple,
                                     .above = index,
                                     .below = interface->ior};
      index = interface->ior;
    } else if (layer.depth() > 0) {
      add_layer({&layer.medium, layer.depth(), channels(layer.albedo), channels(layer.f0),
                 layer.f0 != Rgb(1)},
                static_cast<int>(k));
    }
  }
  if (!stack.substrate) return;
  if (boundaries.back()) add_layer(gap, -1);
  substrate_albedo = channels(stack.substrate->albedo);
  law = stack.substrate->law;
  if (!stack.substrate->model.empty() && !law)
    throw std::invalid_argument(
        "the substrate's model has no law: see compare/request/substrate_model.h");
}

bool BoundaryStack::is_trapped(int layer, Direction w) const {
  const auto reflects = [w](const std::optional<Dielectric>& boundary, double z) {
    return boundary && boundary->is_smooth() &&
           boundary->smooth_refraction({w.x, w.y, z}).cosine == 0;
  };
  // Above the layer light arrives from below, and the other way round.
  return reflects(boundaries[layer], -std::abs(w.z)) &&
         reflects(boundaries[layer + 1], std::abs(w.z)) && !(layer + 1 == count() && has_substrate);
}

}  // namespace lamella
