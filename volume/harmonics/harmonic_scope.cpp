#include "volume/harmonics/harmonic_scope.h"

#include <algorithm>
#include <cmath>

#include "volume/harmonics/axial_normals.h"
#include "volume/harmonics/harmonic_kernel.h"

namespace lamella {

double narrowest_feature(const Stack& stack) {
  double width = 1;
  for (const Layer& layer : stack.layers) {
    if (layer.interface || layer.depth() == 0) continue;
    width =
        std::min(width, has_normals(layer.medium) ? width_of_normals(layer.medium)
                                                  : 1 - std::abs(traits(layer.medium).mean_cosine));
  }
  return width;
}

std::optional<std::string> why_not_harmonic(const Stack& stack) {
  if (stack.has_grid()) return "a grid varies a layer's density laterally";
  if (stack.grains()) return "the stack is explicit geometry";
  if (stack.has_boundaries())
    return "interfaces and surfaces other than Lambert's beside layers without symmetry about the "
           "normal are left to walks";
  for (const Layer& layer : stack.layers) {
    if (layer.interface || layer.depth() == 0) continue;
    if (auto reason = why_no_harmonics(layer.medium)) return reason;
    if (std::isinf(layer.depth()) && !traits(layer.medium).two_sided)
      return "a half space of tilted one-sided flakes is left to walks";
  }
  return std::nullopt;
}

}  // namespace lamella
