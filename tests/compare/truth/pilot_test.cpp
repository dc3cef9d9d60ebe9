#include "compare/truth/pilot.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

// The factors below are far from what either was measured at (some 40 and 20 on scalar kernels): a
// pilot is short.
TEST(Pilot, TakesNextEventForCellsAndAnalogForEnergiesOfSmoothFlakes) {
  const Stack stack = parse_stack(
      "[[layer]]\nmedium = \"vmf_flake\"\nroughness = 0.5\nalbedo = 0.4\nthickness = inf\n", "test",
      "test");
  Plan plan = make_plan(stack);
  plan.isa = Isa::scalar;
  const Direction wi = direction_from_degrees(60, 0);
  TruthRequest request{.stack = stack, .cells = CellGrid{16, 32, true}};
  request.effort.seconds = 1;
  const Pilot cells = pilot(request, plan, wi);
  EXPECT_EQ(cells.best, Estimator::next_event);
  EXPECT_GT(cells.advantage, 3);
  request.effort.target_error = 0.01;
  const Pilot energies = pilot(request, plan, wi);
  EXPECT_EQ(energies.best, Estimator::analog);
  EXPECT_GT(energies.advantage, 2);
}

// White and sharply forward: a walk has thousands of events, and next-event counts each of them in
// 512 cells. The pilot ends in seconds all the same.
TEST(Pilot, LeavesNextEventOutWhereItsFirstWalksTakeTooLong) {
  for (const double g : {0.999, 0.99999}) {
    const Stack stack =
        parse_stack("[[layer]]\nmedium = \"henyey_greenstein\"\ng = " + std::to_string(g) +
                        "\nthickness = inf\n",
                    "test", "test");
    TruthRequest request{.stack = stack, .cells = CellGrid{16, 32, true}};
    request.effort.seconds = 1;
    const auto start = std::chrono::steady_clock::now();
    const Pilot found = pilot(request, make_plan(stack), direction_from_degrees(30, 0));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(found.best, Estimator::analog) << g;
    EXPECT_GT(found.first_seconds, 0) << g;
    EXPECT_LT(taken.count(), 20) << g;
    EXPECT_NE(to_text(found).find("was not tried"), std::string::npos) << g;
  }
}

TEST(Pilot, HasNothingToSayWithoutScattering) {
  const Stack stack = parse_stack(
      "[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = 0.0\nthickness = 1\n", "test", "test");
  TruthRequest request{.stack = stack, .cells = CellGrid{4, 8, true}};
  request.effort.seconds = 1;
  const Pilot found = pilot(request, make_plan(stack), direction_from_degrees(60, 0));
  EXPECT_EQ(found.best, Estimator::analog);
  EXPECT_EQ(found.advantage, 1);
}

}  // namespace
}  // namespace lamella
