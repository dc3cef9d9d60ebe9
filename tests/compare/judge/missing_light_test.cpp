#include "compare/judge/missing_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compare/judge/comparison.h"
#include "phase/random/random.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

constexpr CellGrid kCutCells{4, 8, false};

Stack half_space_of(const std::string& albedo) {
  return parse_stack(
      "[[layer]]\nmedium = \"henyey_greenstein\"\nthickness = inf\nalbedo = " + albedo, "test",
      "test");
}

// A closed form times `factor`, judged by walks of a half space that end after max_order events.
std::vector<LobeComparison> judged_half_space(const std::string& model, const std::string& albedo,
                                              std::uint64_t max_order, double factor = 1,
                                              std::uint64_t walks = 200000) {
  const Stack stack = half_space_of(albedo);
  const ModelInfo& info = *find_model(model);
  Parameters parameters = *info.applies_to(stack);
  fill_defaults(info.parameters, parameters);
  const Plan plan = make_plan(stack, {.max_order = max_order, .thinning = Thinning{0}});
  Simulation simulation(stack, plan, direction_from_degrees(60, 0), Estimator::analog, kCutCells,
                        5);
  simulation.advance(walks);
  const RunResult run = reduce(simulation);
  ProjectedLobes projected =
      project(*info.make(parameters, &stack), info, run.incident, run.grid, true, run.channels);
  for (auto& lobe : projected.lobes)
    for (double& f : lobe) f *= factor;
  std::vector<LobeComparison> lobes = compare(run, &simulation, projected, true);
  std::vector<LobeComparison*> all;
  for (LobeComparison& l : lobes) all.push_back(&l);
  decide(all);
  return lobes;
}

TEST(MissingLight, LeavesTheOrdersUpToTheLimitWhole) {
  RunResult run;
  run.max_order = 2;
  run.unresolved[0] = {0.3, 0.01};
  for (const Order order : {Order::one, Order::two}) {
    EXPECT_FALSE(is_cut(run, order));
    EXPECT_EQ(missing_energy(run, order), std::vector<double>{0});
  }
  for (const Order order : {Order::three, Order::four_plus, Order::all}) {
    EXPECT_TRUE(is_cut(run, order));
    EXPECT_DOUBLE_EQ(missing_energy(run, order)[0], 0.3 + kUnresolvedErrors * 0.01);
  }
  run.unresolved[0] = {};
  EXPECT_FALSE(is_cut(run, Order::all));
  run.unresolved[0] = {0.3, 0};
  run.accuracy.emplace();
  EXPECT_FALSE(is_cut(run, Order::all));
}

// No point of the feasible set, drawn at random, is outside of the range; its ends by hand.
TEST(MissingLight, RangeOfTheSquaredDifferenceIsThatOfTheFeasibleSet) {
  const std::vector<double> model{0.5, 0.2, 0.9, 0.1}, truth{0.4, 0.3, 0.3, 0.1};
  for (const double budget : {0.0, 0.05, 0.3, 0.7, 5.0}) {
    const SquaredDifferences range = squared_differences(model, truth, std::vector{budget});
    RandomStream stream(7, 0, StreamPurpose::test);
    double least = 1e9, most = 0;
    for (int trial = 0; trial < 20000; ++trial) {
      std::vector<double> m(4);
      double sum = 0;
      for (double& x : m) sum += x = std::pow(stream.uniform(), 8);
      const double scale = budget * std::sqrt(stream.uniform()) / sum;
      double square = 0;
      for (int k = 0; k < 4; ++k) square += std::pow(model[k] - truth[k] - scale * m[k], 2) / 4;
      least = std::min(least, square);
      most = std::max(most, square);
    }
    EXPECT_LE(range.least, least + 1e-15) << budget;
    EXPECT_GE(range.most, most - 1e-15) << budget;
  }
  // Differences 0.1, -0.1, 0.6, 0: a budget of 0.3 lowers the 0.6 to 0.3; all of 0.7 is used by two
  // cells; the most is all of it in the cell that the model is below.
  EXPECT_NEAR(squared_differences(model, truth, std::vector{0.3}).least, (0.01 + 0.01 + 0.09) / 4,
              1e-15);
  EXPECT_NEAR(squared_differences(model, truth, std::vector{0.6}).least,
              (0.01 + 2 * 0.05 * 0.05) / 4, 1e-15);
  EXPECT_NEAR(squared_differences(model, truth, std::vector{5.0}).least, 0.01 / 4, 1e-15);
  EXPECT_NEAR(squared_differences(model, truth, std::vector{0.3}).most, (0.01 + 0.16 + 0.36) / 4,
              1e-15);
  EXPECT_NEAR(most_mean_square(truth, std::vector{0.3}),
              (0.16 + 0.09 + 0.09 + 0.01 + 0.3 * (0.3 + 0.8)) / 4, 1e-15);
}

// Chandrasekhar's solution is exact: whatever is cut, it is not off.
TEST(MissingLight, IsNotHeldAgainstAnExactModel) {
  for (const char* albedo : {"1", "0.99"})
    for (const std::uint64_t max_order : {1u, 3u, 10u, 100u}) {
      const auto lobes = judged_half_space("chandrasekhar", albedo, max_order);
      const LobeComparison& all = lobes.back();
      ASSERT_EQ(all.order, Order::all);
      ASSERT_TRUE(all.is_cut());
      EXPECT_EQ(all.verdict, Verdict::insufficient) << albedo << ' ' << max_order;
      // The model shows what is missing: no more than what is told.
      EXPECT_LE(all.energy_model[0],
                all.energy_truth[0] + all.energy_missing[0] + 4 * all.energy_error[0]);
      EXPECT_EQ(all.relative_rmse_least, 0) << albedo << ' ' << max_order;
    }
}

TEST(MissingLight, IsWhatSingleScatteringLacksWhereAllElseIsCut) {
  const auto lobes = judged_half_space("single_scattering", "0.9", 1);
  ASSERT_EQ(lobes.size(), 2u);
  EXPECT_EQ(lobes[0].order, Order::one);
  EXPECT_EQ(lobes[0].verdict, Verdict::agrees);
  EXPECT_FALSE(lobes[0].is_cut());
  EXPECT_EQ(lobes[0].relative_rmse_least, lobes[0].relative_rmse_most);
  EXPECT_EQ(lobes[1].verdict, Verdict::insufficient);
  // Most of what is cut is light that would have left: the model's share of all is a small one.
  EXPECT_GT(lobes[1].energy_missing[0], 0.5);
  EXPECT_GT(lobes[1].relative_rmse_most, 1);
}

TEST(MissingLight, AllowsAVerdictThatItCannotChange) {
  // Walks of albedo 0.9 hold 0.9^100 of their light after 100 events, and few stay so long.
  const auto agreeing = judged_half_space("chandrasekhar", "0.9", 100, 1, 2000000).back();
  ASSERT_TRUE(agreeing.is_cut());
  EXPECT_LT(agreeing.energy_missing[0], 1e-4);
  EXPECT_EQ(agreeing.verdict, Verdict::agrees)
      << agreeing.p_value << ' ' << agreeing.relative_rmse_most;
  EXPECT_LT(agreeing.relative_rmse_most, kAgreesWithin);

  // Too dark by more than the noise, which no missing light mends; the truth's share cut is 5 %.
  const auto dark = judged_half_space("chandrasekhar", "1", 100, 0.7).back();
  EXPECT_EQ(dark.verdict, Verdict::differs);
  // Too bright by more than what is missing.
  const auto bright = judged_half_space("chandrasekhar", "1", 100, 1.5).back();
  EXPECT_EQ(bright.verdict, Verdict::differs);
  EXPECT_GT(bright.relative_rmse_least, 0.1);
  // Too dark by less than what is missing: nobody can tell. Too bright by 2 %: a white half space
  // sends back no more than all, which the missing light makes up for exactly.
  const auto middling = judged_half_space("chandrasekhar", "1", 10, 0.98).back();
  EXPECT_EQ(middling.verdict, Verdict::insufficient);
  EXPECT_EQ(judged_half_space("chandrasekhar", "1", 10, 1.02).back().verdict, Verdict::differs);
}

TEST(MissingLight, RangeHoldsTheErrorOfTheWholeTruth) {
  // The model is off by the factor alone: by |1 - 1 / factor| of itself, 1 less than it of truth.
  for (const double factor : {0.6, 0.8, 1.2, 1.5})
    for (const std::uint64_t max_order : {3u, 30u, 300u}) {
      const auto all = judged_half_space("chandrasekhar", "1", max_order, factor).back();
      EXPECT_LE(all.relative_rmse_least, std::abs(factor - 1) + 0.02) << factor << ' ' << max_order;
      EXPECT_GE(all.relative_rmse_most, std::abs(factor - 1) - 0.02) << factor << ' ' << max_order;
    }
}

}  // namespace
}  // namespace lamella
