#pragma once

#include <functional>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// The means over the cells of one side of an order that is known in closed form, f [1/sr] by w_o;
/// mirror flakes and strong forward scattering may peak about the mirror direction and straight on.
/// tolerance_of_row: absolute, per channel.
[[nodiscard]] std::vector<CellMean> closed_cells(const Stack& stack, const CellGrid& grid,
                                                 Direction wi, bool up,
                                                 const std::vector<Rgb>& tolerance_of_row,
                                                 const std::function<Rgb(Direction)>& order);

}  // namespace lamella
