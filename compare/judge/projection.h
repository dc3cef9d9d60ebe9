#pragma once

#include <array>
#include <vector>

#include "analytic/model/model.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// A closed form on the cells of one side: cosine-weighted means of f [1/sr], [channel][cell], per
/// order in the sequence of Order: of the lobes that stand for it, and all.
struct ProjectedLobes {
  OrderMap<std::vector<double>> lobes;
  OrderMap<bool> has{};  ///< whether the model has a lobe of that order; all: true
  /// The error that refinement left, per cell like the values: the last change, 0 where that is
  /// within kProjectionTolerance. Jumps, noise and features narrower than a panel leave an error.
  OrderMap<std::vector<double>> errors;
  /// Of a stochastic model: lobes of independent estimates, whose scatter is the model's noise.
  std::vector<OrderMap<std::vector<double>>> parts;
};

/// Relative accuracy of a projected cell: a comparison does not count smaller differences.
inline constexpr double kProjectionTolerance = 1e-4;
/// Share of the lobe's mean below which the accuracy is relative to the mean, not to the cell.
inline constexpr double kProjectionFloor = 1e-3;

/// Most panels of a cell along mu and along phi, of four by four points each.
inline constexpr int kProjectionPanels = 32;
/// After this time [s] cells are refined no further, whatever their error.
inline constexpr double kProjectionSeconds = 30;

/// Projects by Gauss-Legendre quadrature over each cell, cut beforehand into small pieces about the
/// mirror direction, w_i and the way straight through, where peaks of any width above 1e-3 radians
/// are found, and refined until a cell's value changes by
/// less than kProjectionTolerance of itself (or of kProjectionFloor of the lobe's mean), at most
/// kProjectionPanels times along mu and phi, and for at most kProjectionSeconds of time. `up`: the
/// side w_o lies on; channels: 1 or 3. A stochastic model's parts, as many as a run has batches,
/// are projected without refinement, as the noise itself need not be accurate. Runs in the calling
/// thread's task arena.
[[nodiscard]] ProjectedLobes project(const Model& model, const ModelInfo& info, Direction wi,
                                     const CellGrid& grid, bool up, int channels);

}  // namespace lamella
