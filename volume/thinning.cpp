// Where thinning pays.

#include "volume/thinning.h"

#include <algorithm>
#include <cmath>

#include "volume/plan.h"

namespace lamella {
namespace {

// A longest walk of fewer events gains nothing: at 100 (albedo 0.99, or a white slab of depth 10)
// cells gain 1.3 times at most, and energies, whose errors do without thinning, lose twice.
constexpr double kLongWalk = 400;
// Events, of particles that scatter evenly.
constexpr std::uint32_t kFirst = 16, kLatestFirst = 1u << 12;

// 1 - g: an event of a forward peak is that part of one.
double turn(const Medium& medium) {
  const auto* hg = std::get_if<HenyeyGreenstein>(&medium);
  return hg ? std::clamp(1 - hg->g, 1e-4, 1.0) : 1;
}

// The largest share of light that an event passes on, over channels; Schlick's factor at its mean.
double passed_on(const Layer& layer) {
  double most = 0;
  for (int c = 0; c < 3; ++c)
    most = std::max(most, layer.albedo[c] * (layer.f0[c] + (1 - layer.f0[c]) / 21));
  return most;
}

}  // namespace

double longest_walk(const Stack& stack, const Plan& plan) {
  double depth = 0, absorbed = 1, drift = 0;
  for (const int k : plan.layers) {
    const Layer& layer = stack.layers[k];
    const double area = (sigma(layer.medium, {0, 0, 1}) + sigma(layer.medium, {0, 0, -1})) / 2;
    depth += layer.depth() * area * turn(layer.medium);
    absorbed = std::min(absorbed, (1 - passed_on(layer)) / turn(layer.medium));
    // One-sided flakes let light out again within so many mean free paths.
    drift = std::max(drift, std::abs(mean_normal(layer.medium).z) / std::max(area, 1e-300));
  }
  // Diffusion: as many events as the square of the way.
  return 1 / (absorbed + 1 / (depth * depth) + drift * drift);
}

Thinning thinning_for(const Stack& stack, const Plan& plan) {
  if (plan.layers.empty() || plan.has_grids()) return {};
  if (std::min(longest_walk(stack, plan), static_cast<double>(plan.max_order)) < kLongWalk)
    return {};
  double least_turn = 1;
  for (const int k : plan.layers) least_turn = std::min(least_turn, turn(stack.layers[k].medium));
  const auto first = static_cast<std::uint32_t>(std::ceil(kFirst / least_turn));
  return {std::min(std::bit_ceil(first), kLatestFirst)};
}

}  // namespace lamella
