#include "volume/solver/deterministic.h"

namespace lamella {

std::optional<std::string> why_not_deterministic(const Stack& stack) {
  if (stack.has_grid()) return "a grid varies a layer's density laterally";
  if (stack.grains()) return "the stack is explicit geometry";
  if (!stack.is_symmetric_about_z()) return "the stack is not symmetric about the normal";
  for (const Layer& layer : stack.layers)
    if (!layer.interface && is_delta(layer.medium))
      return "mirror flakes at roughness 0 scatter into a delta";
  for (const Layer& layer : stack.layers)
    if (layer.interface && layer.interface->multiple)
      return "multiple scattering at an interface's facets is left to walks";
  if (stack.substrate && stack.substrate->law && stack.substrate->law->is_stochastic())
    return stack.substrate->model == kConductor
               ? "multiple scattering at a conductor's facets is left to walks"
               : "the substrate's model is an estimate, which is left to walks";
  if (stack.substrate && !stack.substrate->model.empty() && !stack.substrate->law)
    return "the substrate's model has no law";
  return std::nullopt;
}

}  // namespace lamella
