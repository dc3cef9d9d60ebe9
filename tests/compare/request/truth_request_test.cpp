#include "compare/request/truth_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/request/errors.h"
#include "phase/math/degrees.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

TEST(TruthRequest, AsksForFourDirectionsWhereNoneAreNamed) {
  std::vector<double> thetas;
  for (const Direction w : TruthRequest{}.directions) {
    thetas.push_back(theta_degrees(w));
    EXPECT_EQ(phi_degrees(w), 0);
  }
  EXPECT_THAT(thetas, testing::ElementsAre(0, 30, 60, 80));
}

TEST(TruthRequest, NamesItsEstimatorAndAutoWhereNoneIsAskedFor) {
  for (const char* name : {"auto", "analog", "next-event", "deterministic"}) {
    TruthRequest request;
    request.estimator = parse_estimator(name);
    EXPECT_EQ(estimator_asked(request), name);
  }
  EXPECT_FALSE(parse_estimator("auto"));
  EXPECT_THROW((void)parse_estimator("analogue"), UsageError);
}

TEST(TruthRequest, NamesSettingsOfWalksLikeTheCommandLine) {
  EXPECT_EQ(to_text(WalkSetting::walks), "--walks");
  EXPECT_EQ(to_text(WalkSetting::target_error), "--target-error");
  EXPECT_EQ(to_text(WalkSetting::max_order), "--max-order");
  EXPECT_EQ(to_text(WalkSetting::thin_from), "--thin-from");
  EXPECT_EQ(to_text(WalkSetting::seconds), "--time");
}

TEST(TruthRequest, GivesItsLimitsAndInstructionSetToThePlan) {
  TruthRequest request;
  request.stack =
      parse_stack("[[layer]]\nmedium = \"henyey_greenstein\"\nthickness = 1\n", "test", "test");
  request.limits = {.max_order = 7, .thinning = Thinning{4}};
  request.isa = Isa::sse4;
  const Plan plan = plan_of(request);
  EXPECT_EQ(plan.max_order, 7U);
  EXPECT_EQ(plan.thinning.first, 4U);
  EXPECT_EQ(plan.isa, Isa::sse4);
}

}  // namespace
}  // namespace lamella
