#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analytic/coated/coat.h"

namespace lamella {
namespace {

Dielectric rough_interface(double index, double alpha) {
  Dielectric interface;
  interface.above = 1;
  interface.below = index;
  interface.facets = {.shape = FacetShape::ggx, .alpha_x = alpha, .alpha_y = alpha};
  return interface;
}

// The bounds are those of QuickCoats; fits correct what is left (model_fit.h).
TEST(QuickCoats, AreNearTheExactOnes) {
  for (const auto& [index, alpha] : {std::pair(1.5, 0.05), {2.4, 0.8}}) {
    const Dielectric interface = rough_interface(index, alpha);
    const Rgb color(0.8);
    const Coat exact(interface, color, true);
    const QuickCoats quick;
    const Coat found(interface, color, true);
    double worst = 0, worst_through = 0;
    for (double mu = 1e-3; mu <= 1; mu += 0.0111) {
      worst = std::max(worst, std::abs(found.reflected(mu) - exact.reflected(mu)));
      worst_through =
          std::max(worst_through, std::abs(found.transmitted(mu).r - exact.transmitted(mu).r));
    }
    RecordProperty("worst", std::to_string(worst));
    EXPECT_LT(worst, 1e-4) << index << " " << alpha;
    EXPECT_LT(std::abs(found.reflected_mean() - exact.reflected_mean()), 1e-4);
    EXPECT_LT(worst_through, 1e-3) << index << " " << alpha;
    EXPECT_LT(std::abs(found.internal_mean().r - exact.internal_mean().r), 1e-3);
  }
}

TEST(QuickCoats, EndWhereTheirScopeEnds) {
  const Dielectric interface = rough_interface(1.5, 0.4);
  const Coat exact(interface, Rgb(1), false);
  { const QuickCoats quick; }
  const Coat again(interface, Rgb(1), false);
  EXPECT_EQ(exact.reflected(0.3), again.reflected(0.3));
}

}  // namespace
}  // namespace lamella
