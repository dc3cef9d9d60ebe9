#include "compare/fit/two_lobe_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/ensemble/stack_ensemble.h"
#include "compare/fit/least_squares.h"
#include "compare/fit/nonnegative_least_squares.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

// Solutions over every set of unknowns, by Gauss's elimination.
double least_by_trying(const std::vector<std::vector<double>>& rows, const std::vector<double>& b) {
  const int n = static_cast<int>(rows.front().size());
  double best = 0;
  for (const double v : b) best += v * v;
  for (int set = 1; set < (1 << n); ++set) {
    std::vector<int> at;
    for (int k = 0; k < n; ++k)
      if (set >> k & 1) at.push_back(k);
    const int m = static_cast<int>(at.size());
    std::vector<std::vector<double>> a(m, std::vector<double>(m + 1));
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j)
        for (const auto& row : rows) a[i][j] += row[at[i]] * row[at[j]];
      for (std::size_t r = 0; r < rows.size(); ++r) a[i][m] += rows[r][at[i]] * b[r];
    }
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m; ++j) {
        if (i == j) continue;
        const double factor = a[j][i] / a[i][i];
        for (int k = i; k <= m; ++k) a[j][k] -= factor * a[i][k];
      }
    bool positive = true;
    std::vector<double> x(n);
    for (int i = 0; i < m; ++i) {
      x[at[i]] = a[i][m] / a[i][i];
      positive = positive && x[at[i]] >= 0;
    }
    if (!positive) continue;
    double sum = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      double f = -b[r];
      for (int k = 0; k < n; ++k) f += rows[r][k] * x[k];
      sum += f * f;
    }
    best = std::min(best, sum);
  }
  return best;
}

TEST(NonnegativeLeastSquares, IsTheBestOfAllActiveSets) {
  RandomStream stream(1, 0, StreamPurpose::test);
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + trial % 5;
    std::vector<std::vector<double>> rows;
    std::vector<double> b;
    NormalEquations equations(n);
    for (int r = 0; r < 12; ++r) {
      std::vector<double> row;
      for (int k = 0; k < n; ++k) row.push_back(stream.uniform() - (trial % 3 == 0 ? 0.5 : 0));
      b.push_back(stream.uniform() - 0.3);
      equations.add(row, b.back());
      rows.push_back(std::move(row));
    }
    const std::vector<double> x = nonnegative_solution(equations);
    double sum = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      double f = -b[r];
      for (int k = 0; k < n; ++k) f += rows[r][k] * x[k];
      sum += f * f;
    }
    for (const double v : x) EXPECT_GE(v, 0);
    EXPECT_NEAR(sum, least_by_trying(rows, b), 1e-9);
  }
}

TEST(NonnegativeLeastSquares, LeavesOutColumnsThatSayNothing) {
  NormalEquations equations(3);
  for (const double v : {1.0, 2.0, 3.0}) equations.add(std::vector<double>{v, v, 0}, 2 * v);
  const std::vector<double> x = nonnegative_solution(equations);
  EXPECT_NEAR(x[0] + x[1], 2, 1e-12);
  EXPECT_EQ(x[2], 0);
}

TEST(NonnegativeLeastSquares, KeepsUnknownsWithinTheirBounds) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  // 2 x + y = 4, x - y = 5 has the solution (3, -2) and, not negative, (13 / 5, 0).
  NormalEquations equations(2);
  equations.add(std::vector<double>{2, 1}, 4);
  equations.add(std::vector<double>{1, -1}, 5);
  EXPECT_NEAR(bounded_solution(equations, std::vector{inf, inf})[0], 2.6, 1e-12);
  EXPECT_EQ(bounded_solution(equations, std::vector{inf, inf}), nonnegative_solution(equations));
  // At x = 1: y = 2 and y = -4, whose least is y = 0 as -1 is negative.
  EXPECT_EQ(bounded_solution(equations, std::vector{1.0, inf}), (std::vector<double>{1, 0}));
  // A column of 1e-30 beside one of 1: as much of it as is allowed, and the other as before.
  NormalEquations dark(2);
  for (const double v : {1.0, 2.0, 3.0}) dark.add(std::vector<double>{1, 1e-30 * v}, 1 + 1e-3 * v);
  EXPECT_GT(nonnegative_solution(dark)[1], 1e26);
  const std::vector<double> x = bounded_solution(dark, std::vector{inf, 10.0});
  EXPECT_EQ(x[1], 10);
  EXPECT_NEAR(x[0], 1.002, 1e-12);
}

std::vector<LobeCell> cells_of(const Stack& stack, const SpongecakeLobes& lobes) {
  const Stack second = spongecake_second_stack(stack, lobes.factors);
  std::vector<LobeCell> cells;
  for (const double theta : {10.0, 50.0, 75.0})
    for (const bool reflected : {true, false})
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 8; ++column) {
          LobeCell cell{.wi = direction_from_degrees(theta, 2 * theta), .reflected = reflected};
          cell.wo = cell_nodes(cell.wi, row, column, 4, 8, reflected);
          cell.truth = value_of(second, lobes, cell);
          cells.push_back(cell);
        }
  return cells;
}

TEST(LobeCellNodes, IntegrateCubicsOverACell) {
  const Direction wi = direction_from_degrees(40, 10);
  const double from = 1 - 2.0 / 4, to = 1 - 1.0 / 4;  // of mu^2, in row 1 of 4
  for (const int parts : {1, 2}) {
    const std::vector<Direction> nodes = cell_nodes(wi, 1, 2, 4, 8, true, parts);
    ASSERT_EQ(nodes.size(), static_cast<std::size_t>(4 * parts * parts));
    double cubes = 0, azimuths = 0;
    for (const Direction wo : nodes) {
      cubes += std::pow(wo.z, 6) / static_cast<double>(nodes.size());
      azimuths += (azimuth(wo) - azimuth(wi)) / static_cast<double>(nodes.size());
    }
    EXPECT_NEAR(cubes, (std::pow(to, 4) - std::pow(from, 4)) / (4 * (to - from)), 1e-14);
    EXPECT_NEAR(azimuths, 2 * kPi * 2.5 / 8, 1e-14);
  }
}

TEST(LobeCellNodes, AreMoreForNarrowFlakes) {
  const auto stack = [](double above, double below) {
    Stack two{.name = "two", .layers = {}, .substrate = {}};
    for (const double roughness : {above, below})
      two.layers.push_back(flake_layer(true, roughness, {1, 0, 0}, Rgb(0.5), Rgb(1), 1));
    return two;
  };
  EXPECT_EQ(cell_parts(stack(0.3, 0.2)), 1);
  EXPECT_EQ(cell_parts(stack(0.3, 0.19)), 2);
}

class TwoLobeFits : public ::testing::Test {
  void SetUp() override {
    if (!has_least_squares()) GTEST_SKIP() << "built without Ceres";
  }
};

// Lobes of the form itself are found again, colour in one go.
TEST_F(TwoLobeFits, FindLobesOfTheirOwnForm) {
  const Layer top = flake_layer(true, 0.4, {1, 0, 0}, {0.9, 0.7, 0.4}, {0.6, 0.8, 0.3}, 0.7);
  const Layer bottom = flake_layer(false, 0.6, {0, 0, 1}, {0.5, 0.8, 0.9}, Rgb(1), 2);
  for (const bool two : {false, true}) {
    Stack stack{.name = "own", .layers = {top}, .substrate = {}};
    SpongecakeLobes lobes{.factors = {{.roughness = 1.5,
                                       .depth = 1.4,
                                       .albedo = {0.8, 0.5, 0.2},
                                       .f0 = {0.5, 0.9, 1.2}}},
                          .reflect = {0.02, 0.01, 0.03},
                          .transmit = {0.01, 0.02, 0.005}};
    if (two) {
      stack.layers.push_back(bottom);
      lobes.factors.push_back({.roughness = 1.2, .depth = 0.8, .albedo = {0.4, 0.6, 0.7}});
    }
    const std::vector<LobeCell> cells = cells_of(stack, lobes);
    const TwoLobeFit fit = fit_two_lobes(stack, cells, 3);
    EXPECT_LT(fit.relative_rmse, two ? 5e-3 : 1e-4);
    if (two) continue;  // of two layers other lobes may be as near
    EXPECT_NEAR(fit.lobes.factors[0].roughness, 1.5, 5e-3);
    EXPECT_NEAR(fit.lobes.factors[0].depth, 1.4, 5e-3);
    EXPECT_NEAR(fit.lobes.reflect.g, 0.01, 1e-4);
    EXPECT_NEAR(fit.lobes.transmit.r, 0.01, 1e-4);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(fit.lobes.factors[0].albedo[c], lobes.factors[0].albedo[c], 5e-3);
      EXPECT_NEAR(fit.lobes.factors[0].f0[c], lobes.factors[0].f0[c], 2e-2);
    }
  }
}

// Lobes of the form with a weight of 1e6 of a layer that is all but hidden: the fit may not have
// it, as light from the other side would come back so much brighter. Over a black ground, which
// light reaches through the upper layer alone, it may.
TEST_F(TwoLobeFits, GiveALayerTenTimesTheLightThatMeetsItAtMost) {
  const Layer top = flake_layer(false, 0.9, {0, 0, 1}, Rgb(0.5), Rgb(1), 10);
  const Layer bottom = flake_layer(false, 0.6, {0, 0, 1}, Rgb(0.5), Rgb(1), 2);
  for (const bool open : {true, false}) {
    Stack stack{.name = "hidden", .layers = {top, bottom}, .substrate = {}};
    const SpongecakeLobes lobes{
        .factors = {{}, {.albedo = Rgb(1e6)}}, .reflect = Rgb(0), .transmit = Rgb(0)};
    if (!open) stack.substrate.emplace().albedo = Rgb(0);
    std::vector<LobeCell> cells = cells_of(stack, lobes);
    if (!open) std::erase_if(cells, [](const LobeCell& cell) { return !cell.reflected; });
    const TwoLobeFit fit = fit_two_lobes(stack, cells, 1);
    double above = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      const double tau = stack.layers[k].depth() * fit.lobes.factors[k].depth;
      const double light = std::min(1.0, tau) * (open ? 1 : std::exp(-2 * above));
      // u and v of a layer each.
      EXPECT_LE(0.5 * fit.lobes.factors[k].albedo.r, 20 / light * (1 + 1e-9)) << open << ' ' << k;
      above += tau;
    }
    EXPECT_LT(fit.relative_rmse, open ? 1.0 : 0.05);
  }
}

TEST_F(TwoLobeFits, TakeAnyNumberOfLayers) {
  Stack stack{.name = "many", .layers = {}, .substrate = {}};
  for (int k = 0; k < kSpongecakeLayers + 3; ++k)
    stack.layers.push_back(flake_layer(
        k % 2 == 0, 0.5, k % 2 ? Direction{0, 0, 1} : Direction{1, 0, 0}, Rgb(0.8), Rgb(1), 0.2));
  // The last factors are those of four layers of one roughness and other kinds.
  SpongecakeLobes lobes{.factors = std::vector<SpongecakeFactors>(
                            kSpongecakeLayers, {.roughness = 1.3, .albedo = Rgb(0.5)}),
                        .reflect = Rgb(0.01),
                        .transmit = Rgb(0.02)};
  const TwoLobeFit fit = fit_two_lobes(stack, cells_of(stack, lobes), 1);
  EXPECT_EQ(fit.lobes.factors.size(), static_cast<std::size_t>(kSpongecakeLayers));
  EXPECT_LT(fit.relative_rmse, 0.02);
}

}  // namespace
}  // namespace lamella
