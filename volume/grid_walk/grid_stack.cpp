#include "volume/grid_walk/grid_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lamella {

double common_period(const std::vector<double>& periods) {
  constexpr int kMost = 1000;
  for (int times = 1; times <= kMost && !periods.empty(); ++times) {
    const double length = periods[0] * times;
    if (std::all_of(periods.begin(), periods.end(), [&](double p) {
          const double count = length / p;
          return count > 0.5 && count < kMost + 0.5 &&
                 std::abs(count - std::round(count)) <= 1e-9 * count;
        }))
      return length;
  }
  std::string list;
  for (const double p : periods) list += (list.empty() ? "" : ", ") + to_text(p);
  throw std::invalid_argument(
      fmt::format("key \"size\": found the periods {} mm; allowed: periods of which a length holds "
                  "whole numbers, at most {}",
                  list, kMost));
}

GridWalkStack::GridWalkStack(const Stack& stack, const Plan& plan)
    : has_substrate(stack.substrate.has_value()),
      substrate_albedo{},
      max_order(plan.max_order),
      owned(plan.grids) {
  const auto channels = [](Rgb c) { return std::array<double, 3>{c.r, c.g, c.b}; };
  std::vector<double> x, y;
  for (const int k : plan.layers) {
    const Layer& layer = stack.layers[k];
    const DensityGrid* grid = owned[k].get();
    layers.push_back({&layer.medium, grid, layer.thickness, layer.density, channels(layer.albedo),
                      channels(layer.f0), layer.f0 != Rgb(1)});
    if (!grid) continue;
    x.push_back(layer.grid->size_x);
    y.push_back(layer.grid->size_y);
  }
  try {
    tile_x = common_period(x);
    tile_y = common_period(y);
  } catch (const std::invalid_argument& error) {
    std::string where;
    for (const int k : plan.layers)
      if (owned[k]) where = stack.layers[k].grid->where;
    throw std::invalid_argument(where + ": " + error.what());
  }
  if (stack.substrate) substrate_albedo = channels(stack.substrate->albedo);
}

void check_beside_grids(const char* what, Direction w) {
  if (std::abs(w.z) < kGridGrazing)
    throw std::invalid_argument(
        fmt::format("{}: found mu = {:.3g} on a stack with a density grid; allowed: |mu| >= {}",
                    what, w.z == kGrazingLimit ? 0 : w.z, kGridGrazing));
}

}  // namespace lamella
