#include "phase/stack/stack.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lamella {

bool Substrate::is_grey() const {
  // A metal that reflects everything has no colour, whatever its index.
  if (model == kConductor && parameters.has("fresnel") && parameters.choice("fresnel") == "one")
    return true;
  return albedo.is_grey() && !parameters.has_color();
}

const GrainGeometry* Stack::grains() const {
  return !layers.empty() && layers[0].grains ? &*layers[0].grains : nullptr;
}

void Stack::require_layers(const char* what) const {
  if (grains())
    throw std::invalid_argument(name + " is explicit geometry (" + layers[0].medium_name +
                                "): " + what + " needs layers of media");
}

double Stack::index_of(std::size_t layer) const {
  double index = 1;
  for (std::size_t k = 0; k < std::min(layer, layers.size()); ++k)
    if (layers[k].interface) index = layers[k].interface->ior;
  return index;
}

namespace {

// Whether an interface that changes the index meets the condition.
template <class Condition>
bool any_interface(const Stack& stack, const Condition& condition) {
  double index = 1;
  for (const Layer& layer : stack.layers) {
    if (!layer.interface) continue;
    if (layer.interface->ior != index && condition(*layer.interface)) return true;
    index = layer.interface->ior;
  }
  return false;
}

}  // namespace

bool Stack::has_interfaces() const {
  return any_interface(*this, [](const Interface&) { return true; });
}

bool Stack::has_rough_interfaces() const {
  return any_interface(*this,
                       [](const Interface& i) { return i.facets.shape != FacetShape::smooth; });
}

bool Stack::has_boundaries() const {
  return !grains() && (has_interfaces() || (substrate && !substrate->model.empty()));
}

bool Stack::is_half_space() const { return !layers.empty() && std::isinf(layers.back().depth()); }

bool Stack::has_grid() const {
  return std::any_of(layers.begin(), layers.end(),
                     [](const Layer& l) { return l.grid && l.depth() > 0; });
}

bool Stack::is_grey() const {
  return std::all_of(layers.begin(), layers.end(),
                     [](const Layer& l) { return l.albedo.is_grey() && l.f0.is_grey(); }) &&
         (!substrate || substrate->is_grey());
}

bool Stack::is_symmetric_about_z() const {
  return !has_grid() && std::all_of(layers.begin(), layers.end(), [](const Layer& l) {
    return l.interface ? l.interface->facets.alpha_x == l.interface->facets.alpha_y
                       : bool(traits(l.medium).symmetric_about_z);
  }) && (!substrate || !substrate->law || substrate->law->is_symmetric_about_z());
}

bool Stack::is_reciprocal() const {
  return std::all_of(layers.begin(), layers.end(),
                     [](const Layer& l) {
                       const Direction n = traits(l.medium).mean_normal.value;
                       return n.x == 0 && n.y == 0 && (n.z == 0 || !l.grid);
                     }) &&
         (!substrate || substrate->model.empty() || substrate->model == kConductor);
}

double Stack::one_sidedness() const {
  double sum = 0;
  for (const Layer& layer : layers) {
    const double z = traits(layer.medium).mean_normal.value.z;
    if (z != 0) sum += layer.depth() * z;
  }
  return sum;
}

double Stack::uncollided(Direction w) const {
  refuse_grid(*this, "uncollided light in closed form");
  require_layers("an optical depth");
  refuse_boundaries(*this, "uncollided light in closed form");
  if (is_half_space()) return 0;
  w = with_grazing_limit(w);
  double optical_depth = 0;
  for (const Layer& layer : layers)
    optical_depth += layer.depth() * sigma(layer.medium, w) / std::abs(w.z);
  return std::exp(-optical_depth);
}

void refuse_grid(const Stack& stack, const std::string& what) {
  for (const Layer& layer : stack.layers)
    if (layer.grid && layer.depth() > 0)
      throw std::invalid_argument(layer.grid->where + ": key \"grid\": found \"" +
                                  layer.grid->file + "\", but " + what +
                                  " takes homogeneous layers only; allowed: no grid (lamella "
                                  "homogenise makes such a stack)");
}

void refuse_boundaries(const Stack& stack, const std::string& what) {
  if (stack.has_interfaces())
    throw std::invalid_argument(stack.name + " has interfaces; allowed for " + what +
                                ": layers of one index of refraction");
  if (stack.has_boundaries())
    throw std::invalid_argument(stack.name + " has a substrate that reflects by \"" +
                                stack.substrate->model + "\"; allowed for " + what +
                                ": a Lambertian or black substrate, or none");
}

Stack whitened(Stack stack) {
  for (Layer& layer : stack.layers) {
    if (layer.grid) layer.grid->white = true;
    layer.albedo = Rgb(1);
    layer.f0 = Rgb(1);
    if (layer.parameters.has("f0")) layer.parameters.set("f0", Rgb(1));
  }
  if (stack.substrate) {
    stack.substrate->albedo = Rgb(1);
    for (const char* key : {"albedo", "bulk_albedo", "f0"})
      if (stack.substrate->parameters.has(key)) stack.substrate->parameters.set(key, Rgb(1));
    if (stack.substrate->model == kConductor) {
      auto white = static_cast<const Conductor&>(*stack.substrate->law).setting();
      white.white = true;
      stack.substrate->parameters.set("fresnel", std::string("one"));
      stack.substrate->law = std::make_shared<Conductor>(white);
    } else {
      stack.substrate->law = nullptr;
    }
  }
  return stack;
}

}  // namespace lamella
