#pragma once

#include <vector>

#include "volume/result/cell_grid.h"

namespace lamella {

/// A piece of a cell; phi relative to w_i.
struct CellPiece {
  double mu0, mu1, phi0, phi1;
};

/// The cell, cut finely about the mirror direction, w_i itself and the way straight through, down
/// to pieces of kPeakExtent: a peak there that is narrower than the points of the whole cell lie
/// apart would be missed by all.
[[nodiscard]] std::vector<CellPiece> cell_pieces(const CellGrid& grid, int cell, Direction wi);
inline constexpr double kPeakExtent = 2e-3;  ///< radians

/// What the integral of f mu dmu dphi over a cell is multiplied by to be its mean.
[[nodiscard]] double cell_norm(const CellGrid& grid, int cell);

}  // namespace lamella
