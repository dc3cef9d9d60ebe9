#include "volume/solver/closed_cells.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "volume/solver/critical_cosines.h"

namespace lamella {

std::vector<CellMean> closed_cells(const Stack& stack, const CellGrid& grid, Direction wi, bool up,
                                   const std::vector<Rgb>& tolerance_of_row,
                                   const std::function<Rgb(Direction)>& order) {
  std::vector<CellMean> cells(grid.cells());
  // Interfaces bend what goes straight on.
  const double mu_i = up == (wi.z > 0) ? std::abs(wi.z) : bent_through(stack, wi.z);
  const std::vector<double> kinks = critical_cosines(stack, up);
  const std::vector<std::pair<double, double>> peaks{{mu_i, 0}, {mu_i, kPi}, {mu_i, 2 * kPi}};
  const double turn = azimuth(wi), side = up ? 1 : -1;
  tbb::parallel_for(0, grid.cells(), [&](int cell) {
    const int row = cell / grid.columns(), column = cell % grid.columns();
    cells[cell] = cell_mean(
        [&](double mu, double phi) { return order(direction_from_mu_phi(side * mu, turn + phi)); },
        {grid.edge_mu(row + 1), grid.edge_mu(row), grid.edge_phi(column),
         grid.edge_phi(column + 1)},
        tolerance_of_row[row], peaks, kinks);
  });
  return cells;
}

}  // namespace lamella
