#include <gtest/gtest.h>

#include <cmath>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/stacks.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::layer;
using testing::plan_of;
using testing::stack_from;

RunResult run_of(const Stack& stack, const Plan& plan, Direction wi, Estimator estimator,
                 std::uint64_t walks, std::uint64_t seed = 1) {
  Simulation simulation(stack, plan, wi, estimator, CellGrid{4, 8, false}, seed);
  simulation.advance(walks);
  return reduce(simulation);
}

// Energy that the cells of a side saw, all orders.
double seen(const SideResult& side, const RunResult& run, int channel) {
  const std::size_t cells = run.grid.cells();
  double sum = side.specular[channel].value;
  if (side.lobes[Order::all].value.empty()) return 0;
  for (std::size_t k = 0; k < cells; ++k)
    sum += run.grid.projected_solid_angle() * side.lobes[Order::all].value[channel * cells + k];
  return sum;
}

class Ledger : public testing::OnEveryIsa {};

TEST_P(Ledger, SumsToOnePerChannelForEveryBuiltinStack) {
  for (const BuiltinStack& builtin : builtin_stacks()) {
    const Stack stack = load_stack(builtin.name);
    if (stack.grains()) continue;  // grain_walk_test.cpp
    // A closed form as substrate has its law from the room compare.
    if (stack.substrate && !stack.substrate->model.empty() && !stack.substrate->law) continue;
    const RunResult run =
        run_of(stack, plan_of(stack), direction_from_degrees(60, 30), Estimator::analog, 5000);
    for (int c = 0; c < run.channels; ++c)
      EXPECT_NEAR(ledger_sum(run, c), 1, 1e-12) << builtin.name;  // rounding of 5000 sums
  }
}

TEST_P(Ledger, AbsorbedLightIsOneMinusAlbedoOfEachEventsLight) {
  // Counted on its own: a slab so thin that all but a share of order depth^2 collides once at most.
  const Stack stack = stack_from(
      layer("medium = 'henyey_greenstein'\nalbedo = [0.9, 0.5, 0.2]\nthickness = 0.001"));
  const RunResult run =
      run_of(stack, plan_of(stack), direction_from_degrees(0, 0), Estimator::analog, 400000);
  const double collided = -std::expm1(-0.001);
  for (int c = 0; c < 3; ++c) {
    const double expected = collided * (1 - stack.layers[0].albedo[c]);
    EXPECT_NEAR(run.absorbed[c].value, expected,
                allowed_z() * run.absorbed[c].standard_error + 0.01 * expected);
  }
}

TEST_P(Ledger, WhiteStacksOfEveryMediumKeepTheirEnergy) {
  for (const std::string& medium : testing::every_medium()) {
    const Stack stack = whitened(stack_from(layer(medium + "\nthickness = 1.5")));
    for (const double theta : {30.0, 88.0, 120.0}) {
      const Direction wi = direction_from_degrees(theta, 0);
      const RunResult analog = run_of(stack, plan_of(stack), wi, Estimator::analog, 20000);
      EXPECT_EQ(analog.absorbed[0].value, 0) << medium;
      EXPECT_EQ(analog.unresolved[0].value, 0) << medium;
      // Next-event estimation weighs by sigma and p what the walk samples: its energy is no
      // identity.
      Simulation next(stack, plan_of(stack), wi, Estimator::next_event, CellGrid{4, 8, false}, 2);
      next.advance(20000);
      const double solid_angle = next.targets().grid.projected_solid_angle();
      const Estimate energy = batch_estimate(next.batches(), [&](const BatchTally& b) {
        double sum = b.energy.uncollided[0];
        for (const double f : b.f) sum += solid_angle * f;
        return sum;
      });
      EXPECT_NEAR(energy.value, 1, allowed_z() * energy.standard_error) << medium << ' ' << theta;
    }
  }
}

TEST_P(Ledger, HalfSpaceLeavesWhatTheOrderLimitCutsAsUnresolved) {
  const Stack stack = load_stack("lambert_sphere_white");
  const RunResult run =
      run_of(stack, plan_of(stack, 20), direction_from_degrees(60, 0), Estimator::analog, 20000);
  EXPECT_GT(run.unresolved[0].value, 0.1);
  EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-12);
}

TEST_P(Ledger, SubstrateReflectsAsAnOrderAndAbsorbsTheRest) {
  // Below nothing at all: one reflection, f = albedo / pi.
  const Stack stack = stack_from(layer("medium = 'henyey_greenstein'\nthickness = 0") +
                                 "[substrate]\nalbedo = [0.5, 0.25, 1]\n");
  const RunResult run =
      run_of(stack, plan_of(stack), direction_from_degrees(40, 0), Estimator::next_event, 2000);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(run.reflected.orders[0][c].value, stack.substrate->albedo[c], 1e-12);
    EXPECT_NEAR(run.absorbed[c].value, 1 - stack.substrate->albedo[c], 1e-12);
    for (int cell = 0; cell < run.grid.cells(); ++cell)
      EXPECT_NEAR(run.reflected.lobes[0].value[c * run.grid.cells() + cell],
                  stack.substrate->albedo[c] / kPi, 1e-12);
  }
}

TEST_P(Ledger, AnalogAndNextEventAgreeOnEveryMedium) {
  for (const std::string& medium : testing::every_medium()) {
    const Stack stack =
        stack_from(layer(medium + "\nalbedo = 0.8\nthickness = 1") +
                   layer("medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = 0.5"));
    const Direction wi = direction_from_degrees(65, 40);
    const RunResult a = run_of(stack, plan_of(stack), wi, Estimator::analog, 100000, 1);
    const RunResult n = run_of(stack, plan_of(stack), wi, Estimator::next_event, 10000, 2);
    for (const bool reflected : {true, false}) {
      const SideResult& sa = reflected ? a.reflected : a.transmitted;
      const SideResult& sn = reflected ? n.reflected : n.transmitted;
      for (int o = 0; o <= kTallyOrders; ++o)
        for (std::size_t k = 0; k < sa.lobes[o].value.size(); ++k) {
          const Estimate x{sa.lobes[o].value[k], sa.lobes[o].standard_error[k]};
          const Estimate y{sn.lobes[o].value[k], sn.lobes[o].standard_error[k]};
          // A cell that few photons reached has no normal error.
          if (x.value < 10 * x.standard_error) continue;
          EXPECT_LT(std::abs(testing::z_between(x, y)), 1.3 * allowed_z())
              << medium << " side " << reflected << " order " << o << " cell " << k;
        }
    }
  }
}

TEST(Ledger, ThePlanChangesTheCostAndNotTheAnswer) {
  const Stack stack = load_stack("lambert_sphere_halfspace");
  const Direction wi = direction_from_degrees(60, 0);
  const RunResult narrow = run_of(stack, make_plan(stack), wi, Estimator::analog, 20000);
  const RunResult general = run_of(stack, general_plan(stack), wi, Estimator::analog, 20000);
  // The same walks: only the folding of phi changes what a cell holds.
  EXPECT_EQ(narrow.collisions, general.collisions);
  for (int o = 0; o < kTallyOrders; ++o)
    EXPECT_DOUBLE_EQ(narrow.reflected.orders[o][0].value, general.reflected.orders[o][1].value);
  EXPECT_NEAR(seen(narrow.reflected, narrow, 0), seen(general.reflected, general, 2), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, Ledger, ::testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return to_text(isa.param); });

}  // namespace
}  // namespace lamella
