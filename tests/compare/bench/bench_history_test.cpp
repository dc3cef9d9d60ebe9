#include "compare/bench/bench_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;

Json row(const std::string& what, Json seconds, Json ratio = nullptr) {
  return {{"what", what}, {"seconds", std::move(seconds)}, {"ratio_to_baseline", std::move(ratio)}};
}

TEST(BenchHistory, ARowIsComparedByTheNumberThatSuffersLeastFromTheMachine) {
  EXPECT_EQ(speed_of(row("a", 2, 3))->measure, "ratio_to_baseline");
  EXPECT_EQ(speed_of(row("a", 2))->measure, "seconds");
  EXPECT_EQ(speed_of(row("a", 2))->value, 0.5);
  EXPECT_FALSE(speed_of(row("a", nullptr)));
  EXPECT_FALSE(speed_of(row("a", 0)));
}

TEST(BenchHistory, RoundsGiveMediansAndTheSpreadOfTheComparedNumber) {
  const Json all = combined_rounds({{row("a", 1, 10), row("b", 4)},
                                    {row("a", 3, 12), row("b", 2)},
                                    {row("a", 2, 11), row("c", 1), row("b", 3)}});
  ASSERT_EQ(all.size(), 2);
  EXPECT_EQ(all[0]["what"], "a");
  EXPECT_EQ(all[0]["seconds"], 2);
  EXPECT_EQ(all[0]["ratio_to_baseline"], 11);
  EXPECT_NEAR(all[0]["spread"].get<double>(), 1.0 / 11, 1e-15);
  EXPECT_EQ(all[1]["seconds"], 3);
  EXPECT_NEAR(all[1]["spread"].get<double>(), 0.5 * (1. / 2 - 1. / 4) * 3, 1e-15);
  EXPECT_FALSE(combined_rounds({{row("a", 1)}})[0].contains("spread"));
}

TEST(BenchHistory, ARowFellOnlyBeyondTheNoiseOfBoth) {
  Json before = {row("same", 1, 10), row("fell", 1, 10), row("noisy", 1, 10),
                 row("gone", 1),     row("rose", 2),     row("other", 1, 3)};
  before[2]["spread"] = 0.15;
  Json now = {row("same", 9, 9.6), row("fell", 1, 9.4), row("noisy", 1, 8.2),
              row("new", 1),       row("rose", 1),      row("other", 1)};
  now[2]["spread"] = 0.1;
  const auto changes = changes_between(before, now);
  ASSERT_EQ(changes.size(), 7);
  const auto of = [&](const std::string& what) {
    for (const BenchChange& c : changes)
      if (c.what == what) return c;
    return BenchChange{};
  };
  EXPECT_FALSE(of("same").fell() || of("same").rose());
  EXPECT_TRUE(of("fell").fell());
  EXPECT_FALSE(of("noisy").fell());
  EXPECT_NEAR(of("noisy").noise, 0.25, 1e-15);
  EXPECT_TRUE(of("rose").rose());
  EXPECT_EQ(*of("rose").ratio, 2);
  EXPECT_FALSE(of("gone").ratio || of("gone").now || of("new").before || of("other").ratio);
}

TEST(BenchHistory, RefusesWhatIsNoMeasurementOfTheSameKind) {
  const std::string file =
      (std::filesystem::temp_directory_path() / "lamella_bench_history_test.json").string();
  const auto refusal = [&](const std::string& text, const char* isa = "avx2", bool quick = false) {
    std::ofstream(file) << text;
    try {
      static_cast<void>(read_bench_file(file, isa, quick));
      return std::string();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
  };
  const char* good =
      R"({"command": "bench", "isa": "avx2", "quick": false, "rows": [{"what": "a"}]})";
  EXPECT_EQ(refusal(good), "");
  EXPECT_THAT(refusal(good, "avx512"), HasSubstr("isa \"avx2\", this run has avx512"));
  EXPECT_THAT(refusal(good, "avx2", true), HasSubstr("without --quick"));
  EXPECT_THAT(refusal("{"), HasSubstr("is no JSON"));
  EXPECT_THAT(refusal("[]"), HasSubstr("is no JSON"));
  EXPECT_THAT(refusal(R"({"command": "compare"})"), HasSubstr("no result of bench"));
  EXPECT_THAT(refusal(R"({"command": "bench", "rows": [1]})"), HasSubstr("a row without a name"));
  std::filesystem::remove(file);
  EXPECT_THROW(static_cast<void>(read_bench_file(file, "avx2", false)), std::invalid_argument);
}

}  // namespace
}  // namespace lamella
