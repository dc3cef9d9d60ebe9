#include "volume/solver/closed_cells.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "volume/solver/critical_cosines.h"

namespace lamella {
namespace {

// The lobe of facets of roughness alpha is some alpha long in elevation, and wide in azimuth as
// alpha over the tangent: near grazing it is a ridge along the plane of incidence.
Ridge facet_ridge(const Stack& stack, Direction wi) {
  constexpr double kLeastMu = 1e-3;
  double alpha = kPi;
  for (const Layer& layer : stack.layers)
    if (layer.interface && layer.interface->facets.shape != FacetShape::smooth)
      alpha = std::min({alpha, layer.interface->facets.alpha_x, layer.interface->facets.alpha_y});
  if (alpha == kPi) return {};
  const double mu = std::max(std::abs(wi.z), kLeastMu);
  const double sine = std::max(std::sqrt((1 - wi.z) * (1 + wi.z)), alpha);
  return {kPi, std::min(kPi, alpha * mu / sine), alpha};
}

}  // namespace

std::vector<CellMean> closed_cells(const Stack& stack, const CellGrid& grid, Direction wi, bool up,
                                   const std::vector<Rgb>& tolerance_of_row,
                                   const std::function<Rgb(Direction)>& order) {
  std::vector<CellMean> cells(grid.cells());
  // Interfaces bend what goes straight on.
  const double mu_i = up == (wi.z > 0) ? std::abs(wi.z) : bent_through(stack, wi.z);
  const std::vector<double> kinks = critical_cosines(stack, up);
  const std::vector<std::pair<double, double>> peaks{{mu_i, 0}, {mu_i, kPi}, {mu_i, 2 * kPi}};
  const Ridge ridge = facet_ridge(stack, wi);
  const double turn = azimuth(wi), side = up ? 1 : -1;
  tbb::parallel_for(0, grid.cells(), [&](int cell) {
    const int row = cell / grid.columns(), column = cell % grid.columns();
    cells[cell] = cell_mean(
        [&](double mu, double phi) { return order(direction_from_mu_phi(side * mu, turn + phi)); },
        {grid.edge_mu(row + 1), grid.edge_mu(row), grid.edge_phi(column),
         grid.edge_phi(column + 1)},
        tolerance_of_row[row], peaks, kinks, ridge);
  });
  return cells;
}

}  // namespace lamella
