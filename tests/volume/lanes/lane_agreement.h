#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tests/volume/run/stacks.h"

namespace lamella::testing {

/// Energies, orders and cells of two runs within the noise of both, and `rounding`; the ledger of
/// the first is 1 as sums in fixed point are.
inline void expect_same_lobes(const RunResult& a, const RunResult& b, const std::string& what,
                              double rounding = 0) {
  const auto agree = [&](Estimate x, Estimate y, const std::string& which) {
    // Too few walks for a normal error on either side: none to compare.
    if (x.value < 6 * x.standard_error || y.value < 6 * y.standard_error) return;
    if (std::abs(x.value - y.value) < rounding) return;
    EXPECT_LT(std::abs(z_between(x, y)), allowed_z())
        << what << ' ' << which << ' ' << x.value << ' ' << y.value;
  };
  for (int c = 0; c < a.channels; ++c) {
    EXPECT_NEAR(ledger_sum(a, c), 1, 1e-9) << what;
    agree(a.uncollided[c], b.uncollided[c], "uncollided");
    agree(a.absorbed[c], b.absorbed[c], "absorbed");
    agree(a.lost[c], b.lost[c], "lost");
    for (const bool reflected : {true, false}) {
      const SideResult& x = reflected ? a.reflected : a.transmitted;
      const SideResult& y = reflected ? b.reflected : b.transmitted;
      const std::string side = reflected ? "reflected" : "transmitted";
      agree(x.total[c], y.total[c], side);
      agree(x.zero[c], y.zero[c], side + " order 0");
      agree(x.specular[c], y.specular[c], side + " specular");
      for (int o = 0; o < kTallyOrders; ++o)
        agree(x.orders[o][c], y.orders[o][c], side + " order " + std::to_string(o + 1));
      for (std::size_t o = 0; o < x.lobes.size(); ++o) {
        ASSERT_EQ(x.lobes[o].value.size(), y.lobes[o].value.size());
        const std::size_t cells = x.lobes[o].value.size() / a.channels;
        for (std::size_t j = c * cells; j < (c + 1) * cells; ++j)
          agree({x.lobes[o].value[j], x.lobes[o].standard_error[j]},
                {y.lobes[o].value[j], y.lobes[o].standard_error[j]},
                side + " cell " + std::to_string(j) + " lobe " + std::to_string(o));
      }
    }
  }
}

}  // namespace lamella::testing
