// Results whose order 1 is a closed form: their books, their errors, and the check by the walks.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "phase/math/degrees.h"
#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/stacks.h"
#include "volume/run/first_check.h"
#include "volume/run/saved_walks.h"

namespace lamella {
namespace {

constexpr CellGrid kFirstCells{4, 8, false};
constexpr std::uint64_t kFirstWalks = 1 << 16;

std::unique_ptr<Simulation> first_walked(const Stack& stack, OrderOne order_one,
                                         Estimator estimator, std::uint64_t seed = 1,
                                         std::uint64_t walks = kFirstWalks) {
  Plan plan = make_plan(stack, {.sampling = Sampling::rqmc, .order_one = order_one});
  plan.isa = supported_isas().back();
  auto simulation = std::make_unique<Simulation>(stack, plan, direction_from_degrees(60, 30),
                                                 estimator, kFirstCells, seed);
  simulation->advance(walks);
  return simulation;
}

std::vector<Stack> first_stacks() {
  return {
      load_stack("sggx_slab"), load_stack("vmf_halfspace"), load_stack("spongecake_fabric"),
      testing::stack_from(testing::layer("medium = 'vmf_flake'\nroughness = 0.4\nthickness = 0.5") +
                          "[substrate]\nalbedo = [0.5, 0.9, 0.2]\n"),
      testing::stack_from(testing::layer("interface = 'smooth'\nior = 1.5") +
                          testing::layer("medium = 'lambert_sphere'\nthickness = 1") +
                          "[substrate]\nalbedo = 0.5\n"),
      // Under an interface the beams cross media that see their azimuth, and their side.
      testing::stack_from(testing::layer("interface = 'smooth'\nior = 1.3") +
                          testing::layer("medium = 'sggx'\nshape = 'fiber'\nroughness = 0.5\n"
                                         "axis = [1, 2, 0.4]\nthickness = 1") +
                          testing::layer("medium = 'vmf_flake'\nflake = 'mirror'\nroughness = "
                                         "0.8\naxis = [-1, 0.5, 1]\nthickness = 0.5") +
                          "[substrate]\nalbedo = 0.5\n")};
}

TEST(ExactOrderOne, TakesTheVarianceOfOrderOneOutOfTheSumAndKeepsTheBooks) {
  for (const Stack& stack : first_stacks())
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const auto simulation = first_walked(stack, OrderOne::exact, estimator);
      const RunResult exact = reduce(*simulation);
      const RunResult counted = reduce(*first_walked(stack, OrderOne::walked, estimator));
      ASSERT_EQ(exact.order_one, OrderOne::exact) << stack.name;
      ASSERT_EQ(counted.order_one, OrderOne::walked);
      EXPECT_TRUE(exact.is_bounded(Order::one) && !exact.is_bounded(Order::all));
      for (int c = 0; c < exact.channels; ++c) {
        EXPECT_NEAR(ledger_sum(exact, c), 1, 1e-12) << stack.name;
        EXPECT_LT(std::abs(testing::z_between(exact.absorbed[c], counted.absorbed[c])),
                  testing::allowed_z());
        EXPECT_LE(exact.absorbed[c].standard_error, counted.absorbed[c].standard_error);
      }
      for (const bool reflected : {true, false}) {
        const SideResult& a = reflected ? exact.reflected : exact.transmitted;
        const SideResult& b = reflected ? counted.reflected : counted.transmitted;
        const LobeEstimate &one = a.lobes[Order::one], &rest = a.lobes[Order::multiple];
        const LobeEstimate& all = a.lobes[Order::all];
        EXPECT_EQ(rest.value, b.lobes[Order::multiple].value);
        for (std::size_t k = 0; k < one.value.size(); ++k) {
          EXPECT_NEAR(all.value[k], one.value[k] + rest.value[k], 1e-12 * all.value[k]);
          const double error = rest.standard_error[k];
          EXPECT_NEAR(all.standard_error[k], error > 0 ? one.standard_error[k] + error : 0,
                      1e-12 * all.value[k]);
          EXPECT_LT(one.standard_error[k], 1e-4 * std::max(one.value[k], 0.1));
        }
        for (int c = 0; c < exact.channels && !one.value.empty(); ++c) {
          double energy = 0;
          for (int k = 0; k < exact.grid.cells(); ++k)
            energy += exact.grid.projected_solid_angle() *
                      one.value[static_cast<std::size_t>(c) * exact.grid.cells() + k];
          EXPECT_NEAR(a.orders[0][c].value, energy, 1e-12);
          // A regression adds no noise to an account. It is on the sum of all known ones, both
          // sides and what was not collided, so that a total may lose a little of what order 1 of
          // its own side would tell: 1.4 % at most here.
          EXPECT_LE(a.multiple[c].standard_error,
                    b.multiple[c].standard_error * (1 + 1e-12) + a.orders[0][c].standard_error);
          EXPECT_LE(a.total[c].standard_error,
                    b.total[c].standard_error * 1.05 + a.orders[0][c].standard_error);
          EXPECT_NEAR(a.total[c].value, a.zero[c].value + energy + a.multiple[c].value, 1e-12);
          double orders = a.zero[c].value;
          for (int o = 0; o < kTallyOrders; ++o) orders += a.orders[o][c].value;
          EXPECT_NEAR(a.total[c].value, orders, 1e-12);
        }
      }
    }
}

// A white half space reflects everything, whatever the orders' shares.
TEST(ExactOrderOne, AddsNoNoiseToASumThatHasNone) {
  const Stack stack = testing::stack_from(
      testing::layer("medium = 'lambert_sphere'\nthickness = 3") + "[substrate]\nalbedo = 1\n");
  const RunResult run = reduce(*first_walked(stack, OrderOne::exact, Estimator::analog));
  EXPECT_EQ(run.order_one, OrderOne::exact);
  EXPECT_NEAR(run.reflected.total[0].value + run.unresolved[0].value, 1, 1e-12);
  EXPECT_LT(run.reflected.total[0].standard_error, 1e-12);
}

// In thin layers few walks have a second event, or none.
TEST(ExactOrderOne, HasErrorsThatCoverWhatFewWalksHaveNotSeen) {
  const Stack stack = testing::stack_from(
      testing::layer("medium = 'henyey_greenstein'\ng = 0\nalbedo = 0.9\nthickness = 0.002"));
  for (const Isa isa : {Isa::scalar, supported_isas().back()}) {
    Plan plan = make_plan(stack, {.order_one = OrderOne::exact});
    plan.isa = isa;
    const Direction wi = direction_from_degrees(30, 0);
    const auto run_of = [&](std::uint64_t walks) {
      Simulation simulation(stack, plan, wi, Estimator::analog, CellGrid{2, 4, false}, 5);
      simulation.advance(walks);
      return reduce(simulation);
    };
    const RunResult few = run_of(20000), many = run_of(4000000);
    ASSERT_EQ(few.order_one, OrderOne::exact);
    for (const bool up : {true, false}) {
      const SideResult& of_many = up ? many.reflected : many.transmitted;
      const SideResult& of_few = up ? few.reflected : few.transmitted;
      const Estimate known = of_many.multiple[0], seen = of_few.multiple[0];
      EXPECT_GT(known.value, 1e-7);
      EXPECT_GT(seen.standard_error, 0);
      EXPECT_LT(std::abs(testing::z_between(seen, known)), testing::allowed_z());
      const Estimate all = of_few.total[0];
      EXPECT_GE(all.standard_error, 0.99 * seen.standard_error);
      // No more than the light of a walk or two.
      EXPECT_LT(seen.standard_error, 2 * 0.81 / 20000 * std::sqrt(11));
    }
  }
}

TEST(ExactOrderOne, IsWalkedWhereItWouldTakeLongerThanTheWalks) {
  const Stack stack = load_stack("sggx_slab");
  const auto simulation = first_walked(stack, OrderOne::exact, Estimator::analog, 1, 1000);
  const RunResult few = reduce(*simulation);
  EXPECT_EQ(few.order_one, OrderOne::walked);
  EXPECT_EQ(few.order_one_p_value, 1);
  simulation->advance(kFirstWalks);
  EXPECT_EQ(reduce(*simulation).order_one, OrderOne::exact);
}

// The tallies hold what walks counted: parts are put together before order 1 is made exact.
TEST(ExactOrderOne, IsTheSameForAnyThreadsAndParts) {
  const Stack stack = load_stack("spongecake_fabric");
  const auto on_threads = [](int threads, const auto& work) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    tbb::task_arena arena(threads);
    return arena.execute(work);
  };
  const auto lobes = [](const RunResult& run) {
    std::vector<double> numbers{run.order_one_p_value, run.absorbed[0].value};
    for (const SideResult* side : {&run.reflected, &run.transmitted})
      for (const LobeEstimate& lobe : side->lobes) {
        numbers.insert(numbers.end(), lobe.value.begin(), lobe.value.end());
        numbers.insert(numbers.end(), lobe.standard_error.begin(), lobe.standard_error.end());
      }
    return numbers;
  };
  const auto whole = on_threads(
      1, [&] { return lobes(reduce(*first_walked(stack, OrderOne::exact, Estimator::analog))); });
  EXPECT_EQ(whole, on_threads(7, [&] {
              return lobes(reduce(*first_walked(stack, OrderOne::exact, Estimator::analog)));
            }));
  const auto merged = first_walked(stack, OrderOne::exact, Estimator::analog, 1, 0);
  std::vector<bool> there;
  for (int p = 0; p < 3; ++p) {
    // Who walks a part may count order 1 or not.
    const auto part =
        first_walked(stack, p == 1 ? OrderOne::walked : OrderOne::exact, Estimator::analog, 1, 0);
    part->walk_only({p * kBatches / 3, (p + 1) * kBatches / 3});
    part->advance(kFirstWalks);
    restore_walks(save_walks(*part, 1, true), *merged, there);
  }
  EXPECT_EQ(lobes(reduce(*merged)), whole);
}

TEST(ExactOrderOne, TargetErrorsAreThoseOfWhatWalksGive) {
  const Stack stack = load_stack("sggx_slab");
  const double exact =
      largest_relative_error(*first_walked(stack, OrderOne::exact, Estimator::analog));
  const double counted =
      largest_relative_error(*first_walked(stack, OrderOne::walked, Estimator::analog));
  EXPECT_GT(exact, 0);
  EXPECT_LE(exact, counted);
}

TEST(FirstCheck, PassesTrueWalksAndFindsAFault) {
  int below_5 = 0, tests = 0;
  for (const Stack& stack : first_stacks())
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event})
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const auto simulation = first_walked(stack, OrderOne::exact, estimator, seed);
        const double p = first_check(*simulation);
        EXPECT_GT(p, testing::test_level()) << stack.name << to_text(estimator) << seed;
        below_5 += p < 0.05;
        ++tests;
        if (seed > 1) continue;
        // Walks that count 30 % too much of it.
        for (int b = 0; b < kBatches; ++b) {
          BatchTally tally = simulation->batches()[b];
          const std::size_t order =
              static_cast<std::size_t>(simulation->plan().channels) * simulation->targets().count();
          for (std::size_t k = 0; k < order; ++k) tally.f[k] *= 1.3;
          for (double& e : tally.energy.up[0]) e *= 1.3;
          simulation->restore(b, std::move(tally), "");
        }
        EXPECT_LT(first_check(*simulation), kImplausibleFirst) << stack.name << to_text(estimator);
        EXPECT_EQ(reduce(*simulation).order_one_p_value, first_check(*simulation));
      }
  const double n = tests;
  EXPECT_LT(below_5, 0.05 * n + testing::allowed_z() * std::sqrt(0.05 * 0.95 * n));
}

}  // namespace
}  // namespace lamella
