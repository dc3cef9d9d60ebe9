#pragma once

#include <cstddef>
#include <vector>

#include "analytic/model/model.h"
#include "compare/truth/ground_truth.h"

namespace lamella {

/// The light of one incident direction that leaves on one side, and its place among the cells.
struct TargetLobe {
  Direction wi{};
  bool reflected = true;
  std::size_t run = 0;        ///< of its incident direction
  double energy_missing = 0;  ///< how much the truth's energy may be too low, as walks were cut
};

/// What models are fitted to: the lobes "all" of some runs, sum over the orders, deltas left out.
struct FitTarget {
  CellGrid grid;
  int channels = 1;
  bool is_bounded = false;  ///< `error` has bounds, not standard errors
  std::vector<TargetLobe> lobes;
  std::vector<double> value, error;  ///< [lobe][channel][cell], means of f [1/sr]

  [[nodiscard]] std::size_t block() const {
    return static_cast<std::size_t>(channels) * static_cast<std::size_t>(grid.cells());
  }
};

/// The lobes "all" of truths that have equal grids and channels. `transmitted`: with those of the
/// other side. Throws std::invalid_argument where there is no light in them.
[[nodiscard]] FitTarget fit_target(const std::vector<Truth>& truths, bool transmitted);

/// The points at which a model is asked for its means over the cells of a target's lobes: Gauss's
/// rule of points x points points in each piece of a cell (judge/cell_pieces.h).
struct CellPoints {
  std::vector<DirectionPair> pairs;
  std::vector<double> weights;    ///< of each pair in its cell's mean
  std::vector<std::size_t> ends;  ///< [lobe][cell]: one past its last pair
};
[[nodiscard]] CellPoints cell_points(const FitTarget& target, int points);

/// The model's means of f over the cells, [lobe][channel][cell]. Equal for any number of threads.
[[nodiscard]] std::vector<double> cell_means(const Model& model, const FitTarget& target,
                                             const CellPoints& points, Isa isa);

}  // namespace lamella
