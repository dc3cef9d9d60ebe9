#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <cmath>

#include "compare/judge/model_furnace.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

constexpr CellGrid kFurnaceGrid{4, 8, false};
constexpr double kLevel = 1e-3;
// Enough for standard errors below kWidestFurnaceError.
constexpr std::uint64_t kManyWalks = 1000000;

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
      const FurnaceRun furnace = judged(whitened(load_stack(name)), estimator,
                                        estimator == Estimator::analog ? 5000 : kManyWalks, true);
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
  EXPECT_EQ(judged(grey, Estimator::next_event, kManyWalks, false).verdict, FurnaceVerdict::pass);
}

TEST(Furnace, OfTooFewWalksIsInconclusive) {
  for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
    // Thinning gives analog walks a noise, too; without it they lose nothing to the last bit.
    const Stack stack = load_stack("lambert_sphere_white");
    Simulation simulation(stack, make_plan(stack), direction_from_degrees(60, 0), estimator,
                          kFurnaceGrid, 3);
    simulation.advance(1000);
    const FurnaceRun furnace = judge_furnace(reduce(simulation), &simulation, true, kLevel);
    EXPECT_GT(furnace.energy[0].standard_error, kWidestFurnaceError);
    EXPECT_TRUE(furnace.is_wide);
    EXPECT_EQ(furnace.verdict, FurnaceVerdict::inconclusive) << to_text(estimator);
    EXPECT_FALSE(furnace.loses || furnace.gains);
  }
  const FurnaceRun exact = judged(whitened(load_stack("sggx_slab")), Estimator::analog, 1000, true);
  EXPECT_EQ(exact.verdict, FurnaceVerdict::pass);
  EXPECT_FALSE(exact.is_wide);
}

TEST(Furnace, SaysLossOrGain) {
  const Stack stack = whitened(load_stack("sggx_slab"));
  for (const double factor : {0.97, 1.03}) {
    Simulation simulation(stack, make_plan(stack), direction_from_degrees(60, 0),
                          Estimator::next_event, kFurnaceGrid, 1);
    simulation.advance(200000);
    for (const BatchTally& batch : simulation.batches())
      for (double& f : const_cast<BatchTally&>(batch).f) f *= factor;
    const FurnaceRun furnace = judge_furnace(reduce(simulation), &simulation, true, kLevel);
    EXPECT_EQ(furnace.verdict, FurnaceVerdict::fail);
    EXPECT_EQ(loss_or_gain(furnace.loses, furnace.gains), factor < 1 ? "loss" : "gain");
  }
  const FurnaceRun grey = judged(load_stack("sggx_slab"), Estimator::analog, 2000, true);
  EXPECT_EQ(loss_or_gain(grey.loses, grey.gains), "loss");
}

TEST(Furnace, OfClosedFormsNamesLossGainAndNoise) {
  const auto furnace_of = [](const std::string& name, Parameters parameters, bool as_is,
                             double tolerance) {
    const ModelInfo& info = *find_model(name);
    fill_defaults(info.parameters, parameters);
    return judge_model_furnace(*info.make(parameters, nullptr), direction_from_degrees(60, 0),
                               as_is, tolerance);
  };
  Parameters rough, white, dark;
  rough.set("roughness", 1.0);
  dark.set("albedo", Rgb(0.5));
  EXPECT_EQ(furnace_of("lambert", white, false, 1e-3).verdict, FurnaceVerdict::pass);
  const ModelFurnace fon = furnace_of("fon", rough, false, 1e-3);
  EXPECT_EQ(fon.verdict, FurnaceVerdict::fail);
  EXPECT_EQ(loss_or_gain(fon.loses, fon.gains), "loss");
  EXPECT_EQ(furnace_of("lambert", dark, true, 1e-3).verdict, FurnaceVerdict::pass);
  EXPECT_EQ(furnace_of("lambert", dark, false, 1e-3).verdict, FurnaceVerdict::fail);
  // White facets send back all light of every walk: no noise. Grey ones are known to their noise.
  EXPECT_EQ(furnace_of("beckmann_diffuse", white, false, 1e-3).verdict, FurnaceVerdict::pass);
  Parameters grey;
  grey.set("albedo", Rgb(0.8));
  grey.set("alpha", 1.0);
  const ModelFurnace noisy = furnace_of("beckmann_diffuse", grey, true, 1e-6);
  EXPECT_GT(noisy.error.g, 1e-6);
  EXPECT_EQ(noisy.verdict, FurnaceVerdict::inconclusive);
}

TEST(Furnace, FailsWhereTheEstimatorIsOffByThreePercent) {
  const Stack stack = whitened(load_stack("sggx_slab"));
  Simulation simulation(stack, make_plan(stack), direction_from_degrees(60, 0),
                        Estimator::next_event, kFurnaceGrid, 1);
  simulation.advance(50000);
  EXPECT_NE(judge_furnace(reduce(simulation), &simulation, true, kLevel).verdict,
            FurnaceVerdict::fail);
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

// Lobes of some degrees, of mirrors (1 by symmetry) and of the flakes of a one-sided slab.
TEST(Furnace, RadianceOfNarrowLobesIsAsPredicted) {
  for (const char* medium :
       {"medium = \"sggx\"\nroughness = 0.02", "medium = \"henyey_greenstein\"\ng = 0.98",
        "medium = \"vmf_flake\"\nroughness = 0.02"}) {
    SCOPED_TRACE(medium);
    const Stack stack =
        parse_stack(std::string("[[layer]]\n") + medium + "\nthickness = 1\n", "test", "test");
    for (const double theta : {0.0, 60.0}) {
      const RadianceCheck check =
          check_radiance(stack, make_plan(stack), direction_from_degrees(theta, 0), 200000, 1);
      const double error = std::hypot(check.standard_error, check.predicted_error);
      EXPECT_NEAR(check.measured, check.predicted, 5 * error) << theta;
      EXPECT_LT(error, 0.1 * check.predicted) << theta;
    }
  }
}

}  // namespace
}  // namespace lamella
