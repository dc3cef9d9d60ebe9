#include "compare/judge/verdict_text.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

TEST(VerdictText, SaysByHowMuchAndWhatWasCut) {
  LobeComparison l;
  l.energy_missing = {0};
  l.verdict = Verdict::differs;
  l.relative_rmse_without_noise = l.relative_rmse_least = l.relative_rmse_most = 1.23;
  EXPECT_EQ(verdict_text(l), "differs by 123 %");
  l.energy_missing = {0.1};
  l.relative_rmse_least = 0.12;
  l.relative_rmse_most = 3;
  EXPECT_EQ(verdict_text(l), "differs by 12 to 300 %");
  EXPECT_NE(verdict_legend({&l}, 100).find("walks were cut after 100 events"), std::string::npos);
  l.energy_missing = {0};
  EXPECT_EQ(verdict_legend({&l}, 100).find("cut"), std::string::npos);
  EXPECT_NE(verdict_legend({&l}, 100).find("none above 10 %"), std::string::npos);
  l.verdict = Verdict::insufficient;
  EXPECT_EQ(verdict_text(l), "insufficient");
}

}  // namespace
}  // namespace lamella
