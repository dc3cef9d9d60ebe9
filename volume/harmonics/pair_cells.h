#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "volume/harmonics/mirror_pairs.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Means over cells of one side of what mirrors scatter twice: where all mirrors share an axis that
/// is not the normal and many cells are asked for, of a field over the whole side (pair_field.h).
/// Else blocks of cells are interpolated by polynomials (legendre_patch.h) in elevation and
/// azimuth, and halved where those hold too little; the means are the polynomials' own.
/// cells: which of the grid's; tolerance_of_row: absolute, per channel. width: of the narrowest
/// kernel [radians], for the first blocks. Nothing for cells that were not begun when `stop` was
/// set. The same arguments give the same bits on any number of threads.
[[nodiscard]] std::vector<std::optional<CellMean>> pair_cells(
    const MirrorPairs& pairs, const CellGrid& grid, Direction wi, bool up,
    const std::vector<int>& cells, const std::vector<Rgb>& tolerance_of_row, double width,
    const std::atomic<bool>* stop);

/// About how many seconds pair_cells would take for one side of all cells, from the time of some
/// pairs, where a field (pair_field.h) serves all cells. Else nothing.
[[nodiscard]] std::optional<double> expected_seconds(const MirrorPairs& pairs, const CellGrid& grid,
                                                     Direction wi, bool up,
                                                     const std::vector<int>& cells,
                                                     const std::vector<Rgb>& tolerance_of_row,
                                                     double tolerance, double width);

}  // namespace lamella
