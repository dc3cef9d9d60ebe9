#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// The layer of a stack that is one half space and nothing else, or nullptr.
[[nodiscard]] inline const Layer* only_half_space(const Stack& stack) {
  return stack.layers.size() == 1 && stack.is_half_space() && !stack.substrate ? &stack.layers[0]
                                                                               : nullptr;
}

/// The parameter "albedo" that the diffuse models share: per channel, in [0, 1], 1 by default.
[[nodiscard]] inline ParameterInfo albedo_parameter(std::string doc) {
  return {.name = "albedo",
          .kind = ParameterKind::color,
          .unit = "1",
          .doc = std::move(doc),
          .default_value = "1",
          .min = 0,
          .max = 1};
}

}  // namespace lamella
