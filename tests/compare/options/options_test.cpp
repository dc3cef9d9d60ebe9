#include "compare/options/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/request/errors.h"
#include "phase/math/degrees.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

Stack slab() {
  return parse_stack("[[layer]]\nmedium = \"henyey_greenstein\"\nthickness = 1\n", "test", "test");
}

TEST(Options, BecomeATypedRequest) {
  Options options;
  options.incident = {"30", "60,90"};
  options.estimator = "next-event";
  options.walks = 5000;
  options.target_error = 0.01;
  options.seconds = 2;
  options.max_order = 9;
  options.thin_from = 16;
  options.sampling = "random";
  options.walk_order_1 = true;
  options.walk_settings = {WalkSetting::walks, WalkSetting::max_order};
  options.tolerance = 1e-3;
  options.grid = "8x16";
  options.seed = 7;
  options.isa = "scalar";
  const TruthRequest request = truth_request(options, slab());
  EXPECT_EQ(request.stack.name, "test");
  ASSERT_EQ(request.directions.size(), 2U);
  EXPECT_EQ(theta_degrees(request.directions[0]), 30);
  EXPECT_EQ(theta_degrees(request.directions[1]), 60);
  EXPECT_EQ(phi_degrees(request.directions[1]), 90);
  EXPECT_EQ(request.estimator, Estimator::next_event);
  EXPECT_EQ(request.effort.walks, 5000U);
  EXPECT_EQ(request.effort.target_error, 0.01);
  EXPECT_EQ(request.effort.seconds, 2);
  EXPECT_EQ(request.limits.max_order, 9U);
  ASSERT_TRUE(request.limits.thinning);
  EXPECT_EQ(request.limits.thinning->first, 16U);
  EXPECT_EQ(request.limits.sampling, Sampling::random);
  EXPECT_EQ(request.limits.order_one, OrderOne::walked);
  EXPECT_THAT(request.given, testing::ElementsAre(WalkSetting::walks, WalkSetting::max_order));
  EXPECT_EQ(request.tolerance, 1e-3);
  EXPECT_EQ(request.cells, (CellGrid{8, 16, false}));
  EXPECT_EQ(request.seed, 7U);
  EXPECT_EQ(request.isa, Isa::scalar);
}

// What a library that builds a request by hand gets is what the program does without options.
TEST(Options, AreThoseOfARequestWhereNothingIsTyped) {
  const TruthRequest typed = truth_request(Options{}, slab()), plain{};
  EXPECT_EQ(typed.directions.size(), plain.directions.size());
  EXPECT_EQ(typed.estimator, plain.estimator);
  EXPECT_EQ(typed.effort.walks, plain.effort.walks);
  EXPECT_FALSE(typed.effort.target_error || typed.effort.seconds || typed.limits.max_order ||
               typed.limits.thinning);
  EXPECT_EQ(typed.limits.sampling, plain.limits.sampling);
  EXPECT_EQ(typed.limits.order_one, plain.limits.order_one);
  EXPECT_TRUE(typed.given.empty());
  EXPECT_EQ(typed.tolerance, plain.tolerance);
  EXPECT_EQ(typed.cells, plain.cells);
  EXPECT_EQ(typed.seed, plain.seed);
}

TEST(Options, AreRefusedWhereTheyDoNotSuitTheStack) {
  Options options;
  options.incident = {"120"};
  EXPECT_NO_THROW((void)truth_request(options, slab()));
  Stack closed = slab();
  closed.substrate = Substrate{};
  EXPECT_THROW((void)truth_request(options, closed), UsageError);
}

}  // namespace
}  // namespace lamella
