#include "compare/truth/ground_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

TruthRequest slab_request() {
  TruthRequest request;
  request.stack = parse_stack(
      "[[layer]]\nmedium = \"henyey_greenstein\"\nthickness = 1\nalbedo = 0.5\n", "test", "slab");
  request.directions = {direction_from_degrees(30, 0), direction_from_degrees(60, 0)};
  request.cells = {4, 8, false};
  request.effort.walks = 5000;
  return request;
}

// Keeps what a monitor is told.
struct Told {
  std::vector<std::string> warnings, labels;
  std::vector<std::uint64_t> walks;
  int finished = 0;

  RunMonitor monitor(const StopFlag* stop = nullptr) {
    RunMonitor m{.stop = stop};
    m.warning = [this](const std::string& message) { warnings.push_back(message); };
    m.progress = [this](const std::string& label, const Progress& p) {
      labels.push_back(label);
      walks.push_back(p.walks);
    };
    m.finished = [this] { ++finished; };
    return m;
  }
};

TEST(GroundTruth, TellsAMonitorHowFarWalksAre) {
  TruthRequest request = slab_request();
  request.estimator = Estimator::analog;
  Told told;
  GroundTruth truth(request, Estimator::analog, told.monitor());
  const Truth found = truth.find(0);
  EXPECT_EQ(found.run.walks, 5000U);
  EXPECT_THAT(told.labels, testing::Each("theta_i 30"));
  ASSERT_FALSE(told.walks.empty());
  EXPECT_EQ(told.walks.back(), 5000U);
  EXPECT_EQ(told.finished, 1);
  EXPECT_THAT(told.warnings, testing::IsEmpty());
}

// A run goes to its first checkpoint, 16 walks of each batch, and ends there.
TEST(GroundTruth, EndsAtTheNextCheckpointOnceItsStopFlagIsSet) {
  TruthRequest request = slab_request();
  request.estimator = Estimator::analog;
  request.effort.walks = 1000000000000;
  request.limits.thinning = Thinning{0};
  const StopFlag stop = true;
  Told told;
  GroundTruth truth(request, Estimator::analog, told.monitor(&stop));
  ASSERT_TRUE(truth.goes_on(0));
  EXPECT_EQ(truth.find(0).run.walks, 16U * kBatches);
  EXPECT_TRUE(truth.is_stopped());
  EXPECT_FALSE(truth.goes_on(1));
}

TEST(GroundTruth, WarnsWhereWalksRunOutBeforeTheTargetErrorIsReached) {
  TruthRequest request = slab_request();
  request.estimator = Estimator::analog;
  request.effort.target_error = 1e-6;
  Told told;
  GroundTruth truth(request, Estimator::analog, told.monitor());
  (void)truth.find(1);
  ASSERT_EQ(told.warnings.size(), 1U);
  EXPECT_THAT(
      told.warnings[0],
      testing::AllOf(testing::StartsWith("theta_i 60: relative error "),
                     testing::EndsWith(" after 5000 walks, short of --target-error 1e-06; raise "
                                       "--walks")));
}

TEST(GroundTruth, WarnsOfSettingsThatMeanNothingToTheSolver) {
  TruthRequest request = slab_request();
  request.estimator = Estimator::deterministic;
  request.tolerance = 1e-2;
  request.effort.seconds = 20;
  request.given = {WalkSetting::walks, WalkSetting::seconds};
  Told told;
  GroundTruth truth(request, Estimator::analog, told.monitor());
  EXPECT_TRUE(truth.find(0).run.is_bounded());
  EXPECT_THAT(told.warnings,
              testing::ElementsAre("--walks means nothing to the deterministic estimator"));
  EXPECT_EQ(told.finished, 0);
}

TEST(GroundTruth, PrintsNothingItself) {
  TruthRequest request = slab_request();
  request.estimator = Estimator::analog;
  request.effort.target_error = 1e-6;
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  GroundTruth truth(request, Estimator::analog);
  (void)truth.find(0);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// White in two channels: long walks are thinned, and next to nothing of them is cut.
TEST(GroundTruth, LeavesLittleUnresolvedOfAHalfSpaceThatIsWhiteInSomeChannels) {
  TruthRequest request = slab_request();
  request.stack = parse_stack(
      "[[layer]]\nmedium = \"vmf_flake\"\nroughness = 1\nalbedo = [0.504, 1, 1]\nthickness = "
      "inf\n",
      "test", "coloured");
  request.estimator = Estimator::analog;
  request.isa = isa_from_text("auto");
  request.effort.walks = 200000;
  GroundTruth truth(request, Estimator::analog);
  EXPECT_TRUE(truth.plan().thinning.is_on());
  const RunResult run = truth.find(0).run;
  for (int c = 0; c < 3; ++c)
    EXPECT_LT(run.unresolved[c].value + 3 * run.unresolved[c].standard_error, 0.015) << c;
}

}  // namespace
}  // namespace lamella
