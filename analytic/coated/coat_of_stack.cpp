#include "analytic/coated/coat_of_stack.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// Parameters of `microfacet` for a conductor as it lies under an index.
Parameters facets_of(const Parameters& conductor, double above) {
  Parameters p;
  p.set("material", std::string(conductor.choice("fresnel") == "one" ? "white" : "conductor"));
  for (const char* key : {"eta", "k"}) p.set(key, (1 / above) * conductor.color(key));
  for (const char* key : {"distribution", "masking"}) p.set(key, conductor.choice(key));
  p.set("roughness", conductor.number("roughness"));
  return p;
}

bool is_isotropic_rough(const Parameters& conductor) {
  return conductor.has("roughness") && std::get_if<double>(&conductor.at("roughness"));
}

// What lies under the coat and the layers that absorb.
bool take_substrate(const Substrate& substrate, const std::vector<ModelInfo>& bases,
                    CoatOfStack& coat) {
  if (substrate.model.empty()) {
    coat.base = "lambert";
    coat.parameters.set("albedo", substrate.albedo);
    return true;
  }
  if (substrate.model == kConductor) {
    if (!is_isotropic_rough(substrate.parameters)) return false;
    coat.base = "microfacet";
    coat.parameters = facets_of(substrate.parameters, coat.ior);
    return true;
  }
  coat.base = substrate.model;
  coat.parameters = substrate.parameters;
  return std::any_of(bases.begin(), bases.end(),
                     [&](const ModelInfo& info) { return info.name == substrate.model; });
}

bool take_half_space(const Layer& layer, const std::vector<ModelInfo>& bases, CoatOfStack& coat) {
  const Stack below{.name = {}, .layers = {layer}, .substrate = {}};
  for (const ModelInfo& info : bases) {
    const auto found = info.applies_to ? info.applies_to(below) : std::nullopt;
    if (!found) continue;
    coat.base = info.name;
    coat.parameters = *found;
    return true;
  }
  return false;
}

}  // namespace

std::optional<CoatOfStack> coat_of(const Stack& stack, const std::vector<ModelInfo>& bases) {
  if (stack.layers.empty() || !stack.layers[0].interface || stack.has_grid()) return std::nullopt;
  const Interface& interface = *stack.layers[0].interface;
  if (interface.facets.alpha_x != interface.facets.alpha_y) return std::nullopt;
  CoatOfStack coat;
  coat.shape = interface.facets.shape;
  coat.alpha = coat.shape == FacetShape::smooth ? 0 : interface.facets.alpha_x;
  coat.ior = interface.ior;
  for (std::size_t k = 1; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    if (layer.interface) return std::nullopt;
    if (k + 1 == stack.layers.size() && stack.is_half_space())
      return take_half_space(layer, bases, coat) ? std::optional(coat) : std::nullopt;
    if (layer.albedo.max() > 0) return std::nullopt;
    coat.color = std::exp(-2 * layer.depth() * sigma(layer.medium, {0, 0, 1})) * coat.color;
  }
  if (!stack.substrate || !take_substrate(*stack.substrate, bases, coat)) return std::nullopt;
  return coat;
}

}  // namespace lamella
