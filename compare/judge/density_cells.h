#pragma once

#include <functional>
#include <span>
#include <vector>

#include "phase/math/direction.h"

namespace lamella {

/// Cells of the sphere in cosine and azimuth, each with about the same share of a sampler's
/// directions, however narrow its lobes are: rows between quantiles of mu of a pilot's directions,
/// columns between quantiles of phi in each row, cut open where the row's widest gap is.
class DensityCells {
 public:
  /// From at least 256 directions of a pilot.
  explicit DensityCells(std::span<const Direction> pilot);

  [[nodiscard]] std::size_t count() const;
  [[nodiscard]] std::size_t cell_of(Direction w) const;

  struct Shares {
    std::vector<double> value, error;  ///< per cell: integral of the density, and its error
  };
  /// Integrals of a density [1/sr] over the cells: Gauss rules of 5 x 5 points on panels between
  /// finer quantiles, which are quartered where the four parts differ from the whole by more than
  /// `tolerance`, up to 12 times; the differences that are left are the error. `stop` ends it early
  /// with what is known, the error of what is left being infinite.
  [[nodiscard]] Shares integrate(const std::function<double(Direction)>& density, double tolerance,
                                 const std::function<bool()>& stop) const;

 private:
  struct Row {
    std::vector<double> mu;                  // edges of its panels, ascending
    double cut = 0;                          // azimuth from which columns are counted
    std::vector<std::vector<double>> phi{};  // per column: edges of its panels from the cut
  };
  std::vector<Row> rows_{};
  std::vector<std::size_t> first_{};  // the first cell of each row
};

}  // namespace lamella
