#include "volume/lanes/lane_marginals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_layers.h"
#include "volume/lanes/lane_setting.h"

namespace lamella {
namespace {

using testing::layer;
using testing::stack_from;

// Cumulative probability of a density on [from, to], by the midpoint rule.
template <class Density>
double cumulative(const Density& density, double from, double to, double end) {
  constexpr int n = 20000;
  double part = 0, whole = 0;
  for (int k = 0; k < n; ++k) {
    part += density(from + (to - from) * (k + 0.5) / n) * (to - from);
    whole += density(from + (end - from) * (k + 0.5) / n) * (end - from);
  }
  return part / whole;
}

TEST(LaneMarginals, TablesInvertTheirDistributions) {
  for (const double kappa : {0.0, 0.3, 1.327, 8.0, 50.0, 2e4}) {
    const std::vector<float> table = vmf_marginals(kappa);
    const auto value = [&](int which, double t) {
      const double scaled = std::min(t * kMarginalPieces, kMarginalPieces - 1e-3);
      const int piece = static_cast<int>(scaled);
      const double x = scaled - piece;
      const float* c = table.data() + 4 * (which * kMarginalPieces + piece);
      return c[0] + x * (c[1] + x * (c[2] + x * static_cast<double>(c[3])));
    };
    // Lengths in which the distributions fall.
    const double scale = std::max(kappa, 1.0), end = std::min(scale, 45.0);
    const double angle_end = std::min(kPi, std::sqrt(90 / std::max(kappa, 1e-3)));
    for (int k = 0; k < 40; ++k) {
      const double t = (k + 0.43) / 40;
      const double by_root = -std::expm1(-kLargestExponential * t * t);
      const double by_cube_root = -std::expm1(-kLargestExponential * t * t * t);
      const double axial = value(0, t) * scale, back = (value(1, t) - 1) * scale;
      EXPECT_NEAR(
          cumulative([&](double y) { return (1 - y / scale) * std::exp(-y * kappa / scale); }, 0,
                     axial, end),
          by_root, 2e-6)
          << kappa << ' ' << t;
      EXPECT_NEAR(
          cumulative([&](double y) { return y * std::exp(-y * kappa / scale); }, 0, back, end),
          by_root, 2e-6 + 1e-7 * scale)
          << kappa << ' ' << t;
      const auto tangential = [&](double angle) {
        return std::pow(std::sin(angle), 2) *
               std::exp(-2 * kappa * std::pow(std::sin(angle / 2), 2));
      };
      const double angle = 2 * std::asin(std::sqrt(std::clamp(value(2, t) / 2, 0.0, 1.0)));
      EXPECT_NEAR(cumulative(tangential, 0, angle, angle_end), by_cube_root, 2e-6)
          << kappa << ' ' << t;
    }
  }
}

// By the plan and the stack alone, so that replays, parts and reruns take the same walks.
TEST(LaneMarginals, NullCollisionsAreTakenInOneLayerOfUprightFlakes) {
  const auto takes = [](const std::string& toml) {
    const Stack stack = stack_from(toml);
    const Plan plan = make_plan(stack);
    const bool counted = LaneSetting<float>(stack, plan, {0, 0, 1}, 1, true).walk.null_collisions;
    EXPECT_EQ(counted, takes_null_collisions(stack, plan)) << toml;
    EXPECT_FALSE(LaneSetting<float>(stack, plan, {0, 0, 1}, 1).walk.null_collisions) << toml;
    return counted;
  };
  const std::string flakes = "medium = 'vmf_flake'\nalbedo = 0.9\n", half = "thickness = inf\n";
  EXPECT_TRUE(takes(layer(flakes + half + "roughness = 0.5")));
  EXPECT_TRUE(takes(layer(flakes + half + "alpha = 0.01\nflake = 'mirror'")));
  EXPECT_TRUE(takes(layer(flakes + "thickness = 3\nroughness = 0.5\naxis = [0, 0, -1]")));
  EXPECT_FALSE(takes(layer(flakes + half + "roughness = 0.5\naxis = [0, 0, -1]")));
  EXPECT_FALSE(takes(layer(flakes + half + "roughness = 0.5\naxis = [0.1, 0, 1]")));
  EXPECT_FALSE(takes(layer(flakes + half + "alpha = 0.005")));
  EXPECT_FALSE(takes(layer(flakes + half + "roughness = 0.5\nflake = 'mirror'\nf0 = 0.04")));
  EXPECT_FALSE(
      takes(layer(flakes + "thickness = 3\nroughness = 0.5") + "[substrate]\nalbedo = 1\n"));
  EXPECT_FALSE(takes(layer("medium = 'lambert_sphere'\nalbedo = 0.9\n" + half)));
}

}  // namespace
}  // namespace lamella
