#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/result/run_result.h"

namespace lamella {

/// Up to how many different texels `auto` solves one by one: beyond it the differences between
/// texels leave more error than the solver takes away, and walks are faster.
inline constexpr std::size_t kMostSolvedTexels = 16;

/// Which texels are the same stack: of each texel the first that equals it, itself among them.
[[nodiscard]] std::vector<std::size_t> first_equals(std::span<const Stack> texels);

/// How many different texels that is.
[[nodiscard]] std::size_t count_different(std::span<const std::size_t> first_equals);

/// The mean of results of the solver over the texels of a map, added one by one in the order of
/// SurfaceStack::texels, all for the same incident directions and cells.
class SolvedTexels {
 public:
  /// `runs`: one per incident direction.
  void add(const std::vector<RunResult>& runs);

  [[nodiscard]] std::size_t count() const { return count_; }
  /// Means of values and of error bounds, with the worst accuracy of any texel.
  [[nodiscard]] std::vector<RunResult> mean() const;
  /// The same values, with standard errors in the place of bounds: how far the mean of texels at
  /// random places, one in each square of the map, is from the mean of the map. Texels 2 j and
  /// 2 j + 1 are of neighbouring squares: with a_j and b_j of n texels the variance is at most the
  /// mean of sum_j (a_j - b_j)^2 / n^2, which counts how squares differ as well (collapsed strata;
  /// Cochran 1977, Sampling Techniques, section 5A.12).
  [[nodiscard]] std::vector<RunResult> map_errors() const;

 private:
  std::size_t count_ = 0;
  std::vector<RunResult> sums_, last_;
  std::vector<RunResult> squares_;  // of differences: in standard_error
};

}  // namespace lamella
