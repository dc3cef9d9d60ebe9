#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// A stack that is a coat over a base, in the parameters of `coated` and `openpbr_diffuse`.
struct CoatOfStack {
  FacetShape shape = FacetShape::smooth;
  double alpha = 0, ior = 1;
  Rgb color{1};           ///< share that two passes along the normal leave: absorbing layers
  std::string base;       ///< a closed form
  Parameters parameters;  ///< its own, as far as the stack has them
};

/// One interface, isotropic, on top; then layers that only absorb, if any; then a substrate that is
/// Lambert's, a rough conductor or one of the closed forms, or a half space that one of them claims
/// to describe. Nothing for any other stack.
[[nodiscard]] std::optional<CoatOfStack> coat_of(const Stack& stack,
                                                 const std::vector<ModelInfo>& bases);

}  // namespace lamella
