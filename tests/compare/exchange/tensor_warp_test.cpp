#include "compare/exchange/tensor_warp.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lamella {
namespace {

constexpr int kRows = 5, kColumns = 7;
// Rounding of sums over a handful of nodes, amplified by roots where the density is small.
constexpr double kRounding = 1e-9;

BilinearWarp bumpy(double phase) {
  std::vector<double> nodes;
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kColumns; ++c) nodes.push_back(1.1 + std::sin(phase + 3 * r + 2 * c));
  return {nodes, kRows, kColumns};
}

TEST(BilinearWarp, InvertUndoesSample) {
  const BilinearWarp warp = bumpy(0.3);
  for (double u = 0.01; u < 1; u += 0.07)
    for (double v = 0.01; v < 1; v += 0.07) {
      const SquarePoint p = warp.sample({u, v}), s = warp.invert(p);
      EXPECT_NEAR(s.u, u, kRounding);
      EXPECT_NEAR(s.v, v, kRounding);
    }
}

TEST(BilinearWarp, TheMapHasTheDensity) {
  // d(s) / d(p) of the inverse is the density: by central differences, whose error is of their
  // step squared.
  const BilinearWarp warp = bumpy(1.7);
  constexpr double kStep = 1e-5, kDifferences = 1e-4;
  for (double u = 0.03; u < 1; u += 0.11)
    for (double v = 0.04; v < 1; v += 0.13) {
      const SquarePoint left = warp.invert({u - kStep, v}), right = warp.invert({u + kStep, v});
      const SquarePoint low = warp.invert({u, v - kStep}), high = warp.invert({u, v + kStep});
      // s.v depends on v alone, so the determinant is a product.
      const double jacobian = (right.u - left.u) * (high.v - low.v) / (4 * kStep * kStep);
      EXPECT_NEAR(jacobian, warp.density({u, v}), kDifferences);
    }
}

TEST(BilinearWarp, TheDensityIntegratesToOne) {
  const BilinearWarp warp = bumpy(0.9);
  // Midpoints: exact for a function that is bilinear in panels of which they are whole multiples.
  constexpr int kPoints = 120;
  double sum = 0;
  for (int i = 0; i < kPoints; ++i)
    for (int j = 0; j < kPoints; ++j)
      sum += warp.density({(i + 0.5) / kPoints, (j + 0.5) / kPoints});
  EXPECT_NEAR(sum / (kPoints * kPoints), 1, kRounding);
}

TEST(BilinearWarp, AMixtureLiesBetweenItsPartsAndEqualsOneAlone) {
  const std::vector<BilinearWarp> warps{bumpy(0.1), bumpy(2.2)};
  const std::vector<std::pair<std::size_t, double>> one{{1, 1.0}}, both{{0, 0.25}, {1, 0.75}};
  const SquarePoint p{0.37, 0.61}, a = warps[0].invert(p), b = warps[1].invert(p);
  EXPECT_DOUBLE_EQ(BilinearWarp::invert_mixed(warps, one, p).u, b.u);
  EXPECT_NEAR(BilinearWarp::invert_mixed(warps, both, p).v, 0.25 * a.v + 0.75 * b.v, kRounding);
}

TEST(BilinearWarp, AValueBetweenNodes) {
  const std::vector<float> nodes{0, 1, 2, 4, 5, 6};
  EXPECT_DOUBLE_EQ(bilinear(nodes, 2, 3, {0.25, 0.5}), 2.5);
  EXPECT_DOUBLE_EQ(bilinear(nodes, 2, 3, {2, -1}), 2);
}

}  // namespace
}  // namespace lamella
