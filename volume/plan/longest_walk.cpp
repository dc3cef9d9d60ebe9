#include "volume/plan/longest_walk.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// Where the longest walks have fewer events (of particles that scatter evenly) it does not pay:
// `lamella bench --only thinning`.
constexpr double kLongWalk = 400;
// Events, of particles that scatter evenly.
constexpr std::uint32_t kFirst = 16, kLatestFirst = 1u << 12;

// 1 - g: an event of a forward peak is that part of one.
double turn(const Medium& medium) { return std::clamp(1 - traits(medium).mean_cosine, 1e-4, 1.0); }

// The largest share of light that an event passes on, over channels; Schlick's factor at its mean.
double passed_on(const Layer& layer) {
  double most = 0;
  for (int c = 0; c < 3; ++c)
    most = std::max(most, layer.albedo[c] * (layer.f0[c] + (1 - layer.f0[c]) / 21));
  return most;
}

// The least of the layers' turns: most of the events of long walks are there.
double least_turn(const Stack& stack, std::span<const int> layers) {
  double least = 1;
  for (const int k : layers) least = std::min(least, turn(stack.layers[k].medium));
  return least;
}

}  // namespace

double longest_walk(const Stack& stack, std::span<const int> layers) {
  double depth = 0, absorbed = 1, drift = 0;
  for (const int k : layers) {
    const Layer& layer = stack.layers[k];
    const double area = (sigma(layer.medium, {0, 0, 1}) + sigma(layer.medium, {0, 0, -1})) / 2;
    depth += layer.depth() * area * turn(layer.medium);
    absorbed = std::min(absorbed, (1 - passed_on(layer)) / turn(layer.medium));
    // One-sided flakes let light out again within 1 / drift mean free paths.
    drift = std::max(drift,
                     std::abs(traits(layer.medium).mean_normal.value.z) / std::max(area, 1e-300));
  }
  // Diffusion: the number of events is the square of the way in mean free paths.
  return (1 + 1 / (absorbed + 1 / (depth * depth) + drift * drift)) / least_turn(stack, layers);
}

Thinning thinning_of(const Stack& stack, std::span<const int> layers) {
  const auto first = static_cast<std::uint32_t>(std::ceil(kFirst / least_turn(stack, layers)));
  return {std::min(std::bit_ceil(first), kLatestFirst)};
}

Thinning thinning_for(const Stack& stack, std::span<const int> layers, std::uint64_t max_order) {
  if (layers.empty() || stack.has_grid()) return {};
  const double longest = longest_walk(stack, layers) * least_turn(stack, layers);
  if (std::min(longest, static_cast<double>(max_order)) < kLongWalk) return {};
  return thinning_of(stack, layers);
}

}  // namespace lamella
