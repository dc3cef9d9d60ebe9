#pragma once

#include <vector>

#include "volume/harmonics/bounded_solution.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// The cosines along which a BoundedSolution is asked for light, so that it has the means over
/// cells: Gauss-Legendre points in the elevation, in each row of cells, in the row at grazing in
/// strips. Rows are cut at critical angles, near which light behaves like a root.
class CellCosines {
 public:
  CellCosines(const CellGrid& grid, const Stack& stack);

  /// Those above the stack and, where it is open, those below it.
  [[nodiscard]] const std::vector<AskedCosine>& asked() const { return asked_; }

  /// The means over the cells of one side. turn: azimuth of the beam [radians].
  [[nodiscard]] HarmonicCells means(const BoundedSolution& solution, bool up, double turn) const;

 private:
  struct Side {
    std::size_t first = 0;                   // of `asked`
    std::vector<double> mu, weight, coarse;  // weights of a mean over a row; of fewer points
    std::vector<int> row;
  };
  [[nodiscard]] Side side_of(const std::vector<double>& critical) const;

  CellGrid grid_;
  Side up_, down_;
  std::vector<AskedCosine> asked_;
};

}  // namespace lamella
