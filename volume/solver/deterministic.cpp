#include "volume/solver/deterministic.h"

namespace lamella {

std::optional<std::string> why_not_deterministic(const Stack& stack) {
  if (stack.has_grid()) return "a grid varies a layer's density laterally";
  if (stack.grains()) return "the stack is explicit geometry";
  if (stack.has_boundaries())
    return "interfaces, and substrates beyond Lambert's law, are left to walks";
  if (!stack.is_symmetric_about_z()) return "the stack is not symmetric about the normal";
  for (const Layer& layer : stack.layers)
    if (is_delta(layer.medium)) return "mirror flakes at roughness 0 scatter into a delta";
  return std::nullopt;
}

}  // namespace lamella
