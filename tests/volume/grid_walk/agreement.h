#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/volume/voxels/grids.h"

namespace lamella::testing {

[[nodiscard]] inline RunResult run_of(const Stack& stack, const Plan& plan, Direction wi,
                                      Estimator estimator, std::uint64_t walks, std::uint64_t seed,
                                      CellGrid cells = CellGrid{4, 8, false}) {
  Simulation simulation(stack, plan, wi, estimator, cells, seed);
  simulation.advance(soaked(walks));
  return reduce(simulation);
}

/// z values of two runs over every lobe's cells and energies, where enough light arrives.
inline void collect_z(const RunResult& a, const RunResult& b, std::vector<double>& z) {
  for (const bool reflected : {true, false}) {
    const SideResult& sa = reflected ? a.reflected : a.transmitted;
    const SideResult& sb = reflected ? b.reflected : b.transmitted;
    for (int o = 0; o < kTallyOrders; ++o)
      // One channel: the others are of the same walks.
      for (std::size_t k = 0; k < sa.lobes[o].value.size() / a.channels; ++k) {
        const Estimate x{sa.lobes[o].value[k], sa.lobes[o].standard_error[k]};
        const Estimate y{sb.lobes[o].value[k], sb.lobes[o].standard_error[k]};
        // Fewer than a hundred effective events, or none, make no normal error.
        if (!(x.value > 10 * x.standard_error && y.value > 10 * y.standard_error)) continue;
        z.push_back(z_between(x, y));
      }
  }
}

/// p-value of the hypothesis that the z values are standard normal: counts in 16 bins of equal
/// chance.
[[nodiscard]] inline double normality_p_value(const std::vector<double>& z) {
  constexpr int kBins = 16;
  std::vector<double> observed(kBins), expected(kBins, static_cast<double>(z.size()) / kBins);
  for (const double x : z)
    ++observed[std::min(kBins - 1, static_cast<int>(kBins * 0.5 * std::erfc(-x / std::sqrt(2.0))))];
  return chi_square_p_value(observed, expected);
}

inline void expect_normal(const std::vector<double>& z) {
  ASSERT_GT(z.size(), 100u);
  EXPECT_GT(normality_p_value(z), test_level()) << z.size() << " cells";
}

/// Two stacks are the same to the walk: no cell and no order is far off. Adds the cells' z values
/// to those that the test holds against the normal distribution in the end.
inline void expect_same(const std::vector<std::pair<RunResult, RunResult>>& runs,
                        const std::string& what, std::vector<double>& all) {
  std::vector<double> z;
  for (const auto& [a, b] : runs) {
    collect_z(a, b, z);
    for (const bool reflected : {true, false})
      for (int o = 0; o < kTallyOrders; ++o)
        for (int c = 0; c < a.channels; ++c)
          EXPECT_LT(std::abs(z_between((reflected ? a.reflected : a.transmitted).orders[o][c],
                                       (reflected ? b.reflected : b.transmitted).orders[o][c])),
                    allowed_z())
              << what << ' ' << reflected << ' ' << o << ' ' << c;
  }
  ASSERT_GT(z.size(), 20u) << what;
  for (const double x : z) EXPECT_LT(std::abs(x), 1.3 * allowed_z()) << what;
  all.insert(all.end(), z.begin(), z.end());
}

}  // namespace lamella::testing
