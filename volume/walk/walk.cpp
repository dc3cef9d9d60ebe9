#include "volume/walk/walk.h"

#include <fmt/format.h>

namespace lamella {

NonFiniteError::NonFiniteError(std::uint64_t seed, std::uint64_t walk, Direction wi)
    : std::runtime_error(fmt::format(
          "a number that is not finite came up in walk {} of seed {} from w_i = ({}, {}, {}); "
          "please report it with the stack",
          walk, seed, wi.x, wi.y, wi.z)) {}

WalkStack::WalkStack(const Stack& stack, const Plan& plan)
    : has_substrate(stack.substrate.has_value()),
      substrate_albedo{},
      max_order(plan.max_order),
      thinning(plan.thinning) {
  const auto channels = [](Rgb c) { return std::array<double, 3>{c.r, c.g, c.b}; };
  for (const int k : plan.layers) {
    const Layer& layer = stack.layers[k];
    layers.push_back({&layer.medium, layer.depth(), channels(layer.albedo), channels(layer.f0),
                      layer.f0 != Rgb(1)});
  }
  if (stack.substrate) substrate_albedo = channels(stack.substrate->albedo);
}

}  // namespace lamella
