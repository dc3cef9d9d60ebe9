#pragma once

#include <cstddef>

#include "phase/lanes/isa.h"

namespace lamella {

/// C += A B, all column by column. scratch: kProductScratch numbers for the thread's own use.
struct MatrixProductTask {
  const double* a;
  std::ptrdiff_t a_stride;  ///< from column to column
  const double* b;
  std::ptrdiff_t b_stride;
  double* c;
  std::ptrdiff_t c_stride;
  std::ptrdiff_t rows, columns, inner;
  double* scratch;
};

/// Columns of A that are packed at a time, and the most rows of a tile of C.
inline constexpr int kProductDepth = 256, kProductRows = 24;
inline constexpr std::size_t kProductScratch = std::size_t{kProductDepth} * kProductRows;

LAMELLA_LANE_FUNCTION(void, multiply_add_lanes, (const MatrixProductTask& task))

}  // namespace lamella
