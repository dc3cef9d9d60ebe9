#include "compare/judge/furnace.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <cmath>

#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

constexpr CellGrid kFurnaceGrid{4, 8, false};
constexpr double kLevel = 1e-3;

FurnaceRun judged(const Stack& stack, Estimator estimator, std::uint64_t walks, bool white,
                  std::uint64_t seed = 1, std::uint64_t max_order = 1000, double level = kLevel) {
  Simulation simulation(stack, make_plan(stack, {.max_order = max_order}),
                        direction_from_degrees(60, 0), estimator, kFurnaceGrid, seed);
  simulation.advance(walks);
  return judge_furnace(reduce(simulation), &simulation, white, level);
}

TEST(Furnace, OfAWhiteSlabPasses) {
  for (const char* name : {"sggx_slab", "hg_slab", "spongecake_sheen", "spongecake_window_shade"})
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const FurnaceRun furnace = judged(whitened(load_stack(name)), estimator, 5000, true);
      EXPECT_EQ(furnace.verdict, FurnaceVerdict::pass) << name;
      EXPECT_NEAR(furnace.energy[0].value, 1, 5 * furnace.energy[0].standard_error + 1e-9) << name;
      EXPECT_NEAR(furnace.expected[0], 1, 1e-9) << name;
    }
}

TEST(Furnace, FailsByChanceNoMoreOftenThanItsLevel) {
  constexpr int kRuns = 300;
  const Stack stack = whitened(load_stack("sggx_slab"));
  int failed = 0;
  for (int seed = 1; seed <= kRuns; ++seed)
    failed += judged(stack, Estimator::next_event, 1000, true, seed, 1000, 0.05).verdict ==
              FurnaceVerdict::fail;
  const boost::math::binomial chance(kRuns, 0.05);
  EXPECT_LE(failed, boost::math::quantile(complement(chance, testing::test_level())));
  EXPECT_GT(failed, 0);  // or the level says nothing
}

TEST(Furnace, OfAWhiteHalfSpaceCutShortIsInconclusive) {
  const FurnaceRun furnace =
      judged(load_stack("lambert_sphere_white"), Estimator::next_event, 5000, true, 1, 20);
  EXPECT_EQ(furnace.verdict, FurnaceVerdict::inconclusive);
  EXPECT_GT(furnace.run.unresolved[0].value, 0.05);
  EXPECT_NEAR(furnace.energy[0].value, furnace.expected[0], 5 * furnace.energy[0].standard_error);
}

TEST(Furnace, FailsWhereAWhiteStackAbsorbs) {
  const Stack grey = load_stack("sggx_slab");
  EXPECT_EQ(judged(grey, Estimator::next_event, 2000, true).verdict, FurnaceVerdict::fail);
  // What the ledger says is absorbed is missing rightly.
  EXPECT_EQ(judged(grey, Estimator::next_event, 2000, false).verdict, FurnaceVerdict::pass);
}

TEST(Furnace, FailsWhereTheEstimatorIsOffByThreePercent) {
  const Stack stack = whitened(load_stack("sggx_slab"));
  Simulation simulation(stack, make_plan(stack), direction_from_degrees(60, 0),
                        Estimator::next_event, kFurnaceGrid, 1);
  simulation.advance(50000);
  EXPECT_EQ(judge_furnace(reduce(simulation), &simulation, true, kLevel).verdict,
            FurnaceVerdict::pass);
  // The batches of a simulation are read-only for good reasons; here one has to be wrong.
  for (const BatchTally& batch : simulation.batches())
    for (double& f : const_cast<BatchTally&>(batch).f) f *= 1.03;
  EXPECT_EQ(judge_furnace(reduce(simulation), &simulation, true, kLevel).verdict,
            FurnaceVerdict::fail);
}

TEST(Furnace, RadianceOfAOneSidedSlabIsAsPredicted) {
  const Stack stack = parse_stack(
      "[[layer]]\nmedium = \"vmf_flake\"\nroughness = 0.5\nthickness = 1.5\n", "test", "test");
  for (const double theta : {0.0, 60.0, 120.0}) {
    const RadianceCheck check =
        check_radiance(stack, make_plan(stack), direction_from_degrees(theta, 0), 200000, 1);
    const double error = std::hypot(check.standard_error, check.predicted_error);
    EXPECT_NEAR(check.measured, check.predicted, 5 * error) << theta;
    EXPECT_LT(error, 0.02) << theta;
    // One-sided flakes are no white body from both sides.
    EXPECT_GT(std::abs(check.predicted - 1), 10 * error) << theta;
  }
}

TEST(Furnace, RadianceOfATwoSidedSlabIsOne) {
  const Stack stack = whitened(load_stack("sggx_slab"));
  const RadianceCheck check =
      check_radiance(stack, make_plan(stack), direction_from_degrees(45, 0), 100000, 1);
  EXPECT_EQ(check.predicted, 1);
  EXPECT_NEAR(check.measured, 1, 5 * check.standard_error);
}

}  // namespace
}  // namespace lamella
