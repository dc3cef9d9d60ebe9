#include "volume/solver/deterministic.h"

namespace lamella {

std::optional<std::string> why_not_deterministic(const Stack& stack) {
  if (stack.has_grid()) return "a grid varies a layer's density laterally";
  if (stack.grains()) return "the stack is explicit geometry";
  if (!stack.is_symmetric_about_z()) return "the stack is not symmetric about the normal";
  for (const Layer& layer : stack.layers)
    if (!layer.interface && is_delta(layer.medium))
      return "mirror flakes at roughness 0 scatter into a delta";
  if (stack.has_rough_interfaces()) return "rough interfaces are left to walks";
  if (stack.substrate && !stack.substrate->model.empty())
    return "substrates beyond Lambert's law are left to walks";
  return std::nullopt;
}

}  // namespace lamella
