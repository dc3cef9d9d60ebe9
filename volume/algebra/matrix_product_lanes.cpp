// Products of matrices of doubles on lanes: tiles of C stay in registers while a packed panel of A
// and columns of B pass by.

#include <hwy/highway.h>

#include "phase/lanes/lanes.h"
#include "volume/algebra/matrix_product_task.h"

namespace lamella::LAMELLA_ISA {
namespace {

using Tag = hn::ScalableTag<double>;
using Vector = hn::Vec<Tag>;
constexpr int kLanes = HWY_LANES(double);
constexpr int kVectors = 3;
constexpr int kRows = kVectors * kLanes;
// Accumulators, the panel's vectors and a broadcast fit the registers: 32 of AVX-512, 16 of others.
constexpr int kColumns = kLanes == 8 ? 8 : 4;
static_assert(kRows <= kProductRows);

// Rows of A, `rows` of them, into panels of kRows with zeros behind the last.
void pack(const double* a, std::ptrdiff_t stride, std::ptrdiff_t rows, std::ptrdiff_t depth,
          double* panel) {
  for (std::ptrdiff_t k = 0; k < depth; ++k) {
    const double* column = a + k * stride;
    double* to = panel + k * kRows;
    std::ptrdiff_t i = 0;
    for (; i < rows; ++i) to[i] = column[i];
    for (; i < kRows; ++i) to[i] = 0;
  }
}

template <int N>
void tile(const double* panel, const double* b, std::ptrdiff_t b_stride, std::ptrdiff_t depth,
          double* c, std::ptrdiff_t c_stride, std::ptrdiff_t rows) {
  const Tag d;
  Vector sum[N][kVectors];
  for (int j = 0; j < N; ++j)
    for (int v = 0; v < kVectors; ++v) sum[j][v] = hn::Zero(d);
  for (std::ptrdiff_t k = 0; k < depth; ++k) {
    const double* row = panel + k * kRows;
    const Vector x = hn::LoadU(d, row), y = hn::LoadU(d, row + kLanes),
                 z = hn::LoadU(d, row + 2 * kLanes);
    for (int j = 0; j < N; ++j) {
      const Vector factor = hn::Set(d, b[k + j * b_stride]);
      sum[j][0] = hn::MulAdd(x, factor, sum[j][0]);
      sum[j][1] = hn::MulAdd(y, factor, sum[j][1]);
      sum[j][2] = hn::MulAdd(z, factor, sum[j][2]);
    }
  }
  if (rows == kRows) {
    for (int j = 0; j < N; ++j)
      for (int v = 0; v < kVectors; ++v) {
        double* to = c + j * c_stride + v * kLanes;
        hn::StoreU(hn::Add(hn::LoadU(d, to), sum[j][v]), d, to);
      }
    return;
  }
  double column[kRows];
  for (int j = 0; j < N; ++j) {
    for (int v = 0; v < kVectors; ++v) hn::StoreU(sum[j][v], d, column + v * kLanes);
    for (std::ptrdiff_t i = 0; i < rows; ++i) c[j * c_stride + i] += column[i];
  }
}

}  // namespace

void multiply_add_lanes(const MatrixProductTask& t) {
  for (std::ptrdiff_t k = 0; k < t.inner; k += kProductDepth) {
    const std::ptrdiff_t depth = t.inner - k < kProductDepth ? t.inner - k : kProductDepth;
    for (std::ptrdiff_t i = 0; i < t.rows; i += kRows) {
      const std::ptrdiff_t rows = t.rows - i < kRows ? t.rows - i : kRows;
      pack(t.a + i + k * t.a_stride, t.a_stride, rows, depth, t.scratch);
      std::ptrdiff_t j = 0;
      for (; j + kColumns <= t.columns; j += kColumns)
        tile<kColumns>(t.scratch, t.b + k + j * t.b_stride, t.b_stride, depth,
                       t.c + i + j * t.c_stride, t.c_stride, rows);
      for (; j < t.columns; ++j)
        tile<1>(t.scratch, t.b + k + j * t.b_stride, t.b_stride, depth, t.c + i + j * t.c_stride,
                t.c_stride, rows);
    }
  }
}

}  // namespace lamella::LAMELLA_ISA
