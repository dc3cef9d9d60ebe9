#include "volume/solver/closed_first.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "phase/stack/single_scattering.h"
#include "volume/solver/closed_cells.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/diffuse_rows.h"

namespace lamella {
namespace {

constexpr std::size_t kMostLayers = 16;

bool any_diffuse(const Stack& stack) {
  return std::any_of(stack.layers.begin(), stack.layers.end(), is_diffuse);
}

// Order 1 but for layers of Lambertian flakes.
Rgb first_but_diffuse(const Stack& stack, Direction wi, Direction wo) {
  std::array<double, kMostLayers> transport{};
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const double twice =
      single_scattering_transport(stack, wi, wo, std::span(transport).first(stack.layers.size()));
  Rgb f;
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    if (!(transport[k] > 0) || is_diffuse(layer)) continue;
    const PhaseValue p = phase(layer.medium, wi, wo);
    f += transport[k] * p.density * (layer.albedo * schlick(layer.f0, p.schlick));
  }
  if (stack.substrate && twice > 0) f += lambert_radiance(twice) * stack.substrate->albedo;
  return f;
}

bool is_all_diffuse(const Stack& stack) {
  return !stack.substrate && std::all_of(stack.layers.begin(), stack.layers.end(), is_diffuse);
}

LobeEstimate side_of(const Stack& stack, const CellGrid& grid, Direction wi, bool up,
                     int channels) {
  const bool diffuse = any_diffuse(stack);
  const auto order = [&](Direction wo) {
    return diffuse ? first_but_diffuse(stack, wi, wo) : closed_orders(stack, wi, wo).one;
  };
  // The mean over the side, from one direction per cell.
  Rgb mean;
  const double turn = azimuth(wi);
  for (int row = 0; row < grid.rows(); ++row) {
    const double mu = std::sqrt(1 - (row + 0.5) / grid.rows());
    for (int column = 0; column < grid.columns(); ++column)
      mean += 1.0 / grid.cells() *
              order(direction_from_mu_phi(up ? mu : -mu,
                                          turn + grid.edge_phi(column) + grid.edge_phi(1) / 2));
    if (diffuse) mean += 1.0 / grid.rows() * diffuse_mean(stack, wi, up, mu);
  }
  Rgb allowed;
  for (int c = 0; c < 3; ++c) allowed[c] = kFirstTolerance * std::max(mean[c], kFaintest);
  std::vector<CellMean> cells(grid.cells());
  if (!is_all_diffuse(stack))
    cells = closed_cells(stack, grid, wi, up, std::vector<Rgb>(grid.rows(), allowed), order);
  if (diffuse) {
    // Its means over rows alone are a quadrature: one tolerance for all channels, as they differ by
    // the albedo.
    const std::vector<CellMean> more =
        diffuse_cells(stack, grid, wi, up, kDiffuseTolerance * std::max(mean.max(), kFaintest));
    for (int k = 0; k < grid.cells(); ++k) {
      cells[k].value += more[k].value;
      cells[k].error += more[k].error;
    }
  }
  LobeEstimate lobe;
  for (int c = 0; c < channels; ++c)
    for (const CellMean& cell : cells) {
      lobe.value.push_back(cell.value[c]);
      lobe.standard_error.push_back(cell.error[c]);
    }
  return lobe;
}

}  // namespace

std::optional<std::string> why_no_closed_first(const Stack& stack) {
  if (stack.grains()) return "explicit geometry has no closed form of it";
  if (stack.has_grid()) return "a density grid has no closed form of it";
  if (stack.layers.size() > kMostLayers)
    return fmt::format("its closed form would take long for {} layers; at most {}",
                       stack.layers.size(), kMostLayers);
  if (!is_first_closed(stack)) return "rough interfaces scatter before it";
  if (stack.substrate && stack.substrate->law &&
      (stack.substrate->law->is_delta() || stack.substrate->law->is_stochastic()))
    return "the substrate's reflection is a delta or has no closed form";
  for (const Layer& layer : stack.layers) {
    if (layer.interface || !(layer.depth() > 0)) continue;
    if (is_delta(layer.medium)) return "delta flakes make a delta of it";
    if (!is_diffuse(layer)) continue;
    if (!traits(layer.medium).symmetric_about_z)
      return "the phase function of tilted Lambertian flakes costs more than walks";
    if (stack.has_boundaries())
      return "the phase function of Lambertian flakes under an interface costs more than walks";
  }
  return std::nullopt;
}

ClosedFirst closed_first(const Stack& stack, const CellGrid& grid, Direction wi, int channels,
                         bool both_sides) {
  wi = with_grazing_limit(wi);
  ClosedFirst first;
  if (wi.z > 0 || both_sides) first.up = side_of(stack, grid, wi, true, channels);
  if (both_sides) first.down = side_of(stack, grid, wi, false, channels);
  if (!stack.has_boundaries() && stack.is_open_below()) first.uncollided = stack.uncollided(wi);
  return first;
}

}  // namespace lamella
