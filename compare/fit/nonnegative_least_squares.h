#pragma once

#include <span>
#include <vector>

namespace lamella {

/// The normal equations A^T A x = A^T b of a linear least-squares problem of a few unknowns, row by
/// row.
class NormalEquations {
 public:
  explicit NormalEquations(int unknowns);
  /// A row of A and its element of b.
  void add(std::span<const double> row, double b);

  /// Gives unknown k that value: it leaves the equations, in which its column is 0.
  void fix(int k, double value);

  [[nodiscard]] int unknowns() const { return unknowns_; }
  [[nodiscard]] double square(int i, int j) const { return squares_[i * unknowns_ + j]; }
  [[nodiscard]] double right(int i) const { return right_[i]; }

 private:
  int unknowns_;
  std::vector<double> squares_, right_;
};

/// The x >= 0 that makes |A x - b| least, by active sets (Lawson and Hanson 1974, "Solving Least
/// Squares Problems", chapter 23). Columns that are 0, or that others span within 1e-10, get 0.
[[nodiscard]] std::vector<double> nonnegative_solution(const NormalEquations& equations);

/// The same with x <= most: as long as an unknown is beyond its bound, the one that is so by the
/// largest factor gets the bound, and the others are found anew. Where no bound is met this is
/// nonnegative_solution; else it is near the least.
[[nodiscard]] std::vector<double> bounded_solution(NormalEquations equations,
                                                   std::span<const double> most);

}  // namespace lamella
