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
  /// Every row has a few points.
  CellCosines(const CellGrid& grid, const Stack& stack);

  /// Those above the stack and, where it is open, those below it.
  [[nodiscard]] const std::vector<AskedCosine>& asked() const { return asked_; }

  /// The means over the cells of one side. turn: azimuth of the beam [radians]. tolerance: of a
  /// mean, relative to the mean over its row. The azimuth takes more points until they leave a
  /// tenth of that, up to 16 in a cell; rows whose elevations leave more are remembered.
  [[nodiscard]] HarmonicCells means(const BoundedSolution& solution, bool up, double turn,
                                    double tolerance);
  /// Gives those rows half as many points again, up to 31, for a solution with more cosines;
  /// whether there are any.
  bool refine();

 private:
  struct Side {
    std::vector<int> points;                 // by row
    std::vector<bool> wants;                 // more of them, by row
    std::size_t first = 0;                   // of `asked`
    std::vector<double> mu, weight, coarse;  // weights of a mean over a row; of fewer points
    std::vector<int> row;
  };
  void place_points();
  void place_points(Side& side, const std::vector<double>& critical) const;

  CellGrid grid_;
  std::vector<double> critical_up_, critical_down_;
  bool is_open_below_;
  double index_below_;
  Side up_, down_;
  std::vector<AskedCosine> asked_;
};

}  // namespace lamella
