#include "compare/judge/side_by_side.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compare/judge/comparison.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

TEST(RelativeError, IsThatOfTheComparisonWithTheSameTruth) {
  const Stack stack = load_stack("lambert_sphere_halfspace");
  const ModelInfo& info = *find_model("lambert_sphere_fast");
  const Plan plan = make_plan(stack);
  Simulation simulation(stack, plan, direction_from_degrees(60, 0), Estimator::analog,
                        CellGrid{4, 8, false}, 1);
  simulation.advance(20000);
  const RunResult run = reduce(simulation);
  const ProjectedLobes model = project(*info.make(*info.applies_to(stack), &stack), info,
                                       run.incident, run.grid, true, run.channels);
  for (const LobeComparison& l : compare(run, &simulation, model, true)) {
    const int order = static_cast<int>(l.order);
    const RelativeError error = relative_error(run.reflected.lobes[order], model.lobes[order]);
    EXPECT_NEAR(error.rmse, l.relative_rmse_without_noise, 1e-12) << order;
    EXPECT_GT(error.noise, 0) << order;
  }
}

TEST(RelativeError, IsOverTheTruthAndWithoutNoise) {
  const LobeEstimate truth{{3, 4}, {0, 0}}, noisy{{3, 4}, {3, 0}};
  EXPECT_DOUBLE_EQ(relative_error(truth, {6, 8}).rmse, 1);
  EXPECT_DOUBLE_EQ(relative_error(truth, {0, 0}).rmse, 1);
  EXPECT_DOUBLE_EQ(relative_error(truth, {3, 9}, {0, 4}).rmse, 3.0 / 5);
  EXPECT_DOUBLE_EQ(relative_error(truth, {3, 9}, {0, 4}).noise, 4.0 / 5);
  // 25 - 9 is left of the truth's square, 25 - 9 of the difference's.
  EXPECT_DOUBLE_EQ(relative_error(noisy, {3, 9}).rmse, 1);
  EXPECT_TRUE(std::isinf(relative_error({{0, 0}, {0, 0}}, {1, 0}).rmse));
  EXPECT_EQ(relative_error({{0, 0}, {0, 0}}, {0, 0}).rmse, 0);
  // Light that cut walks held hides as much as it may add to a cell's square, and removes nothing.
  EXPECT_DOUBLE_EQ(relative_error(truth, {3, 9}, {0, 4}, 9).rmse, 3.0 / 5);
  EXPECT_DOUBLE_EQ(relative_error(truth, {3, 9}, {0, 4}, 9).noise, 1);
}

}  // namespace
}  // namespace lamella
