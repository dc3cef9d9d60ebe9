#pragma once

#include <cstdint>
#include <vector>

#include "compare/request/interrupt.h"
#include "phase/stack/stack.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Orders 2 and up of a stack along some directions, on cells of both sides, by analog walks.
struct MultipleLobes {
  CellGrid grid;
  std::vector<Direction> incident;
  std::uint64_t walks = 0;  ///< per direction
  /// Mean of f [1/sr] over each cell, and its variance: [direction][side][cell][channel], side 0
  /// that of the light. Three channels, equal where the stack is grey.
  std::vector<float> value, variance;

  [[nodiscard]] std::size_t cells_per_direction() const {
    return 2 * static_cast<std::size_t>(grid.cells());
  }
  /// Root mean square of the standard errors over that of the values: the noise per cell.
  [[nodiscard]] double relative_noise() const;
};

/// Walks without thinning, cut after kMaxOrder events, on the lanes of this machine; in the calling
/// thread. `seed`: of these walks alone; every direction has its own numbers. Throws
/// std::invalid_argument for what SampleRun refuses, NonFiniteError. Once `stop` is set what it
/// returns is not whole.
[[nodiscard]] MultipleLobes multiple_lobes(const Stack& stack,
                                           const std::vector<Direction>& incident,
                                           const CellGrid& grid, std::uint64_t walks,
                                           std::uint64_t seed, const StopFlag* stop = nullptr);

}  // namespace lamella
