#include "compare/ensemble/multiple_lobes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "analytic/spongecake_network/spongecake_ranges.h"
#include "compare/ensemble/lobe_dataset.h"
#include "compare/ensemble/spongecake_accuracy.h"
#include "compare/ensemble/stack_ensemble.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

// Two ways to count the same light: rows of walks here, tallies of batches there.
TEST(MultipleLobes, AgreeWithTheSimulation) {
  const CellGrid grid{4, 8, false};
  for (const int layers : {1, 2})
    for (std::uint64_t number = 0; number < 3; ++number) {
      const Stack stack = random_spongecake_stack(layers, 77, number);
      const std::vector<Direction> incident = random_directions(1, layers, 77, number);
      const MultipleLobes lobes = multiple_lobes(stack, incident, grid, 1 << 17, 5);
      Plan plan = make_plan(stack);
      plan.folded = false;
      plan.isa = isa_from_text("auto");
      Simulation simulation(stack, plan, incident[0], Estimator::analog, grid, 6);
      simulation.advance(1 << 17);
      const RunResult run = reduce(simulation);
      double square = 0;
      int count = 0;
      for (const bool reflected : {true, false}) {
        const LobeEstimate& lobe =
            (reflected ? run.reflected : run.transmitted).lobes[Order::multiple];
        for (int cell = 0; cell < grid.cells(); ++cell)
          for (int c = 0; c < plan.channels; ++c) {
            const std::size_t at = 3 * ((reflected ? 0 : grid.cells()) + cell) + c;
            const std::size_t k = static_cast<std::size_t>(c) * grid.cells() + cell;
            const double error = std::hypot(std::sqrt(lobes.variance[at]), lobe.standard_error[k]);
            // Of cells with some hundred events errors are known, and nearly normal.
            if (!(lobe.value[k] > 10 * lobe.standard_error[k])) continue;
            square += std::pow((lobes.value[at] - lobe.value[k]) / error, 2);
            ++count;
          }
      }
      ASSERT_GT(count, 10);
      // Channels share walks: of the order of count / 3 independent numbers.
      EXPECT_NEAR(square / count, 1, 4 * std::sqrt(2.0 / (count / 3.0))) << stack.name;
    }
}

TEST(MultipleLobes, TellTheirNoise) {
  const Stack stack = random_spongecake_stack(1, 1, 4);
  const std::vector<Direction> incident = random_directions(2, 1, 1, 4);
  const double few = multiple_lobes(stack, incident, {4, 8, false}, 1 << 14, 1).relative_noise();
  const double more = multiple_lobes(stack, incident, {4, 8, false}, 1 << 18, 1).relative_noise();
  EXPECT_NEAR(few / more, 4, 0.6);
}

TEST(StackEnsemble, HasStacksWithinTheirRanges) {
  int fibers = 0, home = 0, fresnel = 0;
  for (std::uint64_t number = 0; number < 2000; ++number) {
    const Stack stack = random_spongecake_stack(2, 3, number);
    EXPECT_EQ(why_no_network(random_spongecake_stack(1, 3, number)), "");
    for (const Layer& layer : stack.layers) {
      fibers += layer.parameters.choice("shape") == "fiber";
      fresnel += layer.f0 != Rgb(1);
      const double z = std::abs(layer.parameters.vector("axis").z);
      home += z < 1e-12 || z > 1 - 1e-12;
    }
  }
  // Binomial, 4 standard deviations.
  for (const int count : {fibers, home, fresnel}) EXPECT_NEAR(count, 2000, 4 * std::sqrt(1000.0));
  EXPECT_EQ(to_text(ParameterValue(random_spongecake_stack(1, 3, 7).layers[0].albedo)),
            to_text(ParameterValue(random_spongecake_stack(1, 3, 7).layers[0].albedo)));
  EXPECT_NE(random_spongecake_stack(1, 3, 7).layers[0].albedo,
            random_spongecake_stack(1, 4, 7).layers[0].albedo);
}

// Without lobes everything is left over; with the exact values nothing but the noise, which is
// taken off.
TEST(SpongecakeTrial, MeasuresWhatIsLeftOver) {
  const LobeDatasetPlan plan{.walks = 1 << 16, .seed = 9, .directions = 2};
  const LobeDatum datum = lobe_datum(plan, 3);
  const SpongecakeTrial trial(datum.stack, datum.lobes);
  const LobeErrors none = trial.errors_of(std::nullopt);
  EXPECT_NEAR(none.multiple, 1, 1e-12);
  EXPECT_LT(none.all, 1);
  EXPECT_GT(none.all, 0);
  EXPECT_GT(trial.multiple_share(), 0);
  EXPECT_LT(trial.multiple_share(), 1);
}

}  // namespace
}  // namespace lamella
