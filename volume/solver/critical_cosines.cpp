#include "volume/solver/critical_cosines.h"

#include <algorithm>
#include <cmath>

#include "volume/quadrature/direction_sets.h"

namespace lamella {

std::vector<double> critical_cosines(const Stack& stack, bool above) {
  const double outside = above ? 1 : stack.index_of(stack.layers.size());
  std::vector<double> cosines;
  double before = 1;
  for (const Layer& layer : stack.layers) {
    if (!layer.interface) continue;
    const double rarer = std::min(before, layer.interface->ior);
    before = layer.interface->ior;
    if (layer.interface->facets.shape != FacetShape::smooth || rarer >= outside) continue;
    const double sine = rarer / outside;
    cosines.push_back(std::sqrt((1 - sine) * (1 + sine)));
  }
  std::sort(cosines.begin(), cosines.end());
  cosines.erase(std::unique(cosines.begin(), cosines.end()), cosines.end());
  return cosines;
}

double bent_through(const Stack& stack, double mu) {
  const double above = 1, below = stack.index_of(stack.layers.size());
  return mu > 0 ? snell_cosine(mu, above, below) : snell_cosine(-mu, below, above);
}

}  // namespace lamella
