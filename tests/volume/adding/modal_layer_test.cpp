#include "volume/adding/modal_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/adding/doubling.h"
#include "volume/adding/stack_modes.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

const std::vector<double> kOut{1e-5, 0.01, 0.3, 0.301, 0.6, 0.6000001, 0.95, 1},
    kIn{0.01, 0.3, 0.6, 1};

// The largest difference of f between eigenmodes and doubling, of each series, relative to the
// largest mode 0 of all orders in the same row and column.
struct Differences {
  std::array<double, kSeries> worst{};

  void take(int series, const MatrixXd& f, const MatrixXd& expected, const MatrixXd& scale) {
    ASSERT_EQ(f.rows(), scale.rows());
    for (Index j = 0; j < f.cols(); ++j)
      for (Index i = 0; i < f.rows(); ++i) {
        if (scale(i, j) == 0) continue;
        const double off = std::abs(f(i, j) - expected(i, j)) / scale(i, j);
        if (!(off <= worst[series])) worst[series] = off;
      }
  }
  void expect_below(double tolerance, const std::string& name) const {
    std::printf("[ error ] all %.1e, orders 1 to 3 %.1e %.1e %.1e\n", worst[0], worst[1], worst[2],
                worst[3]);
    for (const double d : worst) EXPECT_LT(d, tolerance) << name;
  }
};

// Between directions that were asked for.
void expect_same_lobes(const std::string& toml, int nodes, int modes, double tolerance) {
  const Stack stack = stack_of(toml);
  StackModes solver(stack, 0, DirectionSets(nodes, kOut, kIn, grazing_map(stack)), 3, Isa::scalar);
  solver.prepare(modes);
  const LayerOperator mean = solver.mode(0);
  Differences off;
  for (int m = 0; m < modes; ++m) {
    const LayerOperator doubled = solver.mode(m);
    const AskedMode found = solver.asked_series(m);
    for (int k = 0; k < kSeries; ++k) {
      const auto asked = [&](const MatrixXd& f) { return asked_block(f, nodes, nodes); };
      off.take(k, found.series[k][kAboveToUp], asked(doubled.above.r[k]), asked(mean.above.r[0]));
      // What a half space lets through is 0 to rounding.
      if (stack.is_half_space()) continue;
      off.take(k, found.series[k][kAboveToDown], asked(doubled.above.t[k]), asked(mean.above.t[0]));
      off.take(k, found.series[k][kBelowToDown], asked(doubled.below.r[k]), asked(mean.below.r[0]));
      off.take(k, found.series[k][kBelowToUp], asked(doubled.below.t[k]), asked(mean.below.t[0]));
    }
  }
  off.expect_below(tolerance, toml);
}

// Twice the largest difference that was measured, 6e-10 of order 3 (its quadrature); others are
// within 6e-12, which is what doubling starts from.
constexpr double kOfDoubling = 1.2e-9;

TEST(ModalLayer, IsWhatDoublingComesTo) {
  expect_same_lobes(layer(henyey_greenstein(0.7), 0.9, 4), 16, 12, kOfDoubling);
  expect_same_lobes(layer(henyey_greenstein(0.7), 1, 0.01), 16, 12, kOfDoubling);
  expect_same_lobes(layer(henyey_greenstein(0.7), 0.9, 30), 16, 12, kOfDoubling);
  expect_same_lobes(layer(henyey_greenstein(-0.9), 1, kInfinity), 24, 12, kOfDoubling);
  expect_same_lobes(layer(kSphere, 0.9, kInfinity), 16, 8, kOfDoubling);
  expect_same_lobes(layer(sggx(0.3, "mirror"), 0.9, 2), 16, 24, kOfDoubling);
  expect_same_lobes(layer(sggx(0.05, "lambert"), 0.9, 2), 16, 8, kOfDoubling);
}

TEST(ModalLayer, AddsUpInStacks) {
  expect_same_lobes(layer(fiber(0.2, "mirror"), 0.9, 2) + layer(henyey_greenstein(0.8), 0.5, 1) +
                        lambert_ground(0.5),
                    16, 24, kOfDoubling);
  expect_same_lobes(layer(sggx(0.3, "mirror"), 0.9, 0.5) + layer(kIsotropic, 1, kInfinity), 12, 12,
                    kOfDoubling);
}

// Nodes too, in irradiance, as interfaces need them.
TEST(ModalLayer, IsAnOperatorOnTheNodes) {
  for (const double depth : {0.3, kInfinity}) {
    const Stack stack = stack_of(layer(henyey_greenstein(0.5), 0.9, depth));
    const DirectionSets sets(12, kOut, kIn);
    constexpr int kModes = 6;
    const LayerScattering scattering(stack.layers[0].medium, 0.9, 1, sets, kModes);
    const auto in_irradiance = [&](MatrixXd f) -> MatrixXd {
      f.topRows(12) = sets.flux.asDiagonal() * f.topRows(12);
      f.leftCols(12) = f.leftCols(12) * sets.flux.asDiagonal();
      return f;
    };
    Differences off;
    for (int m = 1; m < kModes; ++m) {
      const OperatorRules rules{sets, m, 3};
      const LayerOperator doubled = doubled_layer(scattering, depth, rules),
                          found = homogeneous_layer(scattering, depth, rules);
      const MatrixXd one = MatrixXd::Ones(sets.out.size(), sets.in.size());
      for (int k = 0; k < kSeries; ++k) {
        off.take(k, in_irradiance(found.above.r[k]), in_irradiance(doubled.above.r[k]), one);
        off.take(k, in_irradiance(found.below.t[k]), in_irradiance(doubled.below.t[k]), one);
      }
      EXPECT_TRUE(found.above.direct_in.isApprox(doubled.above.direct_in));
    }
    off.expect_below(kOfDoubling, "at the nodes");
  }
}

}  // namespace
}  // namespace lamella
