#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "volume/harmonics/mirror_pairs.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Means over cells of one side of what mirrors scatter twice. Blocks of cells are interpolated by
/// polynomials through 8 x 8 points in elevation and azimuth, and halved where their Legendre
/// series fall too slowly; the means are the polynomials' own.
/// cells: which of the grid's; tolerance_of_row: absolute, per channel. width: of the narrowest
/// kernel [radians], for the first blocks. Nothing for cells that were not begun when `stop` was
/// set. The same arguments give the same bits on any number of threads.
[[nodiscard]] std::vector<std::optional<CellMean>> pair_cells(
    const MirrorPairs& pairs, const CellGrid& grid, Direction wi, bool up,
    const std::vector<int>& cells, const std::vector<Rgb>& tolerance_of_row, double width,
    const std::atomic<bool>* stop);

}  // namespace lamella
