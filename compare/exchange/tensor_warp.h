#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace lamella {

/// A point of the unit square.
struct SquarePoint {
  double u, v;
};

/// A density on the unit square, bilinear between nodes on a grid of rows (v) and columns (u) that
/// reaches the edges, and the map under which uniform points have it: v by the marginal density,
/// then u by the conditional one, as the readers of tensor files do.
class BilinearWarp {
 public:
  /// `nodes`: rows * columns values, not negative, some above 0; at least 2 x 2. They need not be
  /// normalised.
  BilinearWarp(std::vector<double> nodes, int rows, int columns);

  /// The density at a point.
  [[nodiscard]] double density(SquarePoint p) const;
  /// Where a uniform point goes.
  [[nodiscard]] SquarePoint sample(SquarePoint s) const;
  /// Where it came from.
  [[nodiscard]] SquarePoint invert(SquarePoint p) const;
  /// The same of a sum of densities with these weights, which sum to 1; `parts`: indices and
  /// weights of warps on equal grids.
  [[nodiscard]] static SquarePoint invert_mixed(
      std::span<const BilinearWarp> warps, std::span<const std::pair<std::size_t, double>> parts,
      SquarePoint p);

 private:
  // At a point: marginal up to its v, conditional up to its u, and conditional of the whole row.
  struct Sums {
    double marginal, conditional, row;
  };
  [[nodiscard]] Sums sums(SquarePoint p) const;

  int rows_, columns_;
  std::vector<double> nodes_;        // normalised: the integral over the square is 1
  std::vector<double> conditional_;  // per row, integral over u up to each column
  std::vector<double> row_;          // per row, that of the whole row
  std::vector<double> marginal_;     // integral over v up to each row
};

/// The value between nodes on a grid that reaches the edges of the unit square; beyond it the edge.
[[nodiscard]] double bilinear(std::span<const float> nodes, int rows, int columns, SquarePoint p);

}  // namespace lamella
