#include "volume/harmonics/harmonic_scope.h"

#include <algorithm>
#include <cmath>

#include "phase/surface/conductor.h"
#include "volume/harmonics/axial_normals.h"
#include "volume/harmonics/harmonic_kernel.h"

namespace lamella {

namespace {

// The roughness of a ground that tells x from y, a conductor or a closed form.
double width_of_ground(const Stack& stack) {
  if (!stack.substrate || !stack.substrate->law || stack.substrate->law->is_symmetric_about_z())
    return 1;
  if (const auto* conductor = dynamic_cast<const Conductor*>(stack.substrate->law.get()))
    return std::min(conductor->setting().facets.alpha_x, conductor->setting().facets.alpha_y);
  double width = 1;
  for (const char* const key : {"roughness", "roughness_y"})
    if (stack.substrate->parameters.has(key))
      width = std::min(width, stack.substrate->parameters.number(key));
  return width;
}

}  // namespace

double narrowest_feature(const Stack& stack) {
  double width = 1;
  for (const Layer& layer : stack.layers) {
    if (layer.interface && layer.interface->facets.alpha_x != layer.interface->facets.alpha_y)
      width = std::min({width, layer.interface->facets.alpha_x, layer.interface->facets.alpha_y});
    if (layer.interface || layer.depth() == 0) continue;
    width =
        std::min(width, has_normals(layer.medium) ? width_of_normals(layer.medium)
                                                  : 1 - std::abs(traits(layer.medium).mean_cosine));
  }
  return std::min(width, width_of_ground(stack));
}

namespace {

// Of what lies around the layers.
std::optional<std::string> why_not_bounded(const Stack& stack) {
  for (const Layer& layer : stack.layers) {
    if (!layer.interface) continue;
    if (layer.interface->multiple)
      return "multiple scattering at an interface's facets is left to walks";
  }
  if (!stack.substrate || stack.substrate->model.empty()) return std::nullopt;
  if (!stack.substrate->law) return "the substrate's model has no law";
  const SurfaceLaw& law = *stack.substrate->law;
  if (law.is_stochastic())
    return stack.substrate->model == kConductor
               ? "multiple scattering at a conductor's facets is left to walks"
               : "the substrate's model is an estimate, which is left to walks";
  return std::nullopt;
}

}  // namespace

bool is_even(const Stack& stack, std::span<const Direction> incident) {
  // Rounding of an azimuth of pi.
  const auto in_plane = [](Direction w) { return std::abs(w.y) < 1e-15; };
  if (stack.has_boundaries() || !std::all_of(incident.begin(), incident.end(), in_plane))
    return false;
  return std::all_of(stack.layers.begin(), stack.layers.end(), [&](const Layer& layer) {
    if (layer.depth() == 0 || !has_normals(layer.medium)) return true;
    const auto normals = axial_normals(layer.medium);
    return normals && in_plane(normals->axis);
  });
}

std::optional<std::string> why_not_harmonic(const Stack& stack) {
  if (stack.has_grid()) return "a grid varies a layer's density laterally";
  if (stack.grains()) return "the stack is explicit geometry";
  if (auto reason = why_not_bounded(stack)) return reason;
  for (const Layer& layer : stack.layers) {
    if (layer.interface || layer.depth() == 0) continue;
    if (auto reason = why_no_harmonics(layer.medium)) return reason;
  }
  return std::nullopt;
}

}  // namespace lamella
