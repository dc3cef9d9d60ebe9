#include "compare/options/run_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/request/errors.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

Options odd_options() {
  Options options;
  options.incident = {"30", "60,90"};
  options.walks = 12345678901;
  options.target_error = 0.1;
  options.max_order = std::uint64_t{1} << 60;
  options.thin_from = 64;
  options.sampling = "random";
  options.walk_order_1 = true;
  options.walk_settings = {WalkSetting::walks, WalkSetting::thin_from};
  options.tolerance = 1.0 / 3e5;
  options.grid = "3x4";
  options.estimator = "next-event";
  options.seed = 18446744073709551615u;
  options.isa = "scalar";
  options.models = {"lambert,albedo=0.3"};
  options.max_error = 0;
  options.strict = options.preview = true;
  options.sets = {"layer.0.albedo=0.5"};
  options.of = "furnace";
  return options;
}

TEST(RunSettings, ComeBackFromTheirText) {
  const Json settings = settings_json(odd_options());
  const Options back = options_from(Json::parse(settings.dump()), "a.part");
  EXPECT_EQ(settings_json(back), settings);
  EXPECT_EQ(back.seed, 18446744073709551615u);
  EXPECT_EQ(back.sampling, "random");
  EXPECT_TRUE(back.walk_order_1);
  EXPECT_EQ(back.tolerance, 1.0 / 3e5);
  EXPECT_FALSE(back.seconds);
  EXPECT_THAT(back.walk_settings, testing::ElementsAre(WalkSetting::walks, WalkSetting::thin_from));
}

TEST(RunSettings, AutoIsTheSetOfTheMachine) { EXPECT_NE(settings_json(Options{})["isa"], "auto"); }

TEST(RunSettings, EverySettingOfAnotherTypeIsRefused) {
  const Json settings = settings_json(odd_options());
  for (const auto& [key, value] : settings.items()) {
    for (const Json& wrong :
         {Json(Json::object()), Json(Json::array({Json::array()})), Json(-1.5)}) {
      if (key == "target_error" && wrong.is_number()) continue;  // out of its range, below
      Json other = settings;
      other[key] = wrong;
      EXPECT_THROW((void)options_from(other, "a.part"), UsageError) << key << " " << wrong;
    }
    Json other = settings;
    other.erase(key);
    EXPECT_THROW((void)options_from(other, "a.part"), UsageError) << key;
  }
  Json more = settings;
  more["more"] = 1;
  EXPECT_THROW((void)options_from(more, "a.part"), UsageError);
  EXPECT_THROW((void)options_from(Json(), "a.part"), UsageError);
}

TEST(RunSettings, ValuesAreHeldAgainstTheRangesOfTheCommandLine) {
  for (const auto& [key, value] :
       std::vector<std::pair<const char*, Json>>{{"walks", 127},
                                                 {"walks", 1e15},
                                                 {"walks", 1000000000000001},
                                                 {"max_order", 0},
                                                 {"thin_from", 3},
                                                 {"sampling", "sobol"},
                                                 {"thin_from", 1 << 21},
                                                 {"thin_from", 1ull << 40},
                                                 {"tolerance", 0},
                                                 {"target_error", -1},
                                                 {"time", 0},
                                                 {"max_error", -1},
                                                 {"size", 1},
                                                 {"of", "x"},
                                                 {"isa", "auto"},
                                                 {"walk_options", Json::array({"--x"})}}) {
    Json other = settings_json(odd_options());
    other[key] = value;
    EXPECT_THROW((void)options_from(other, "a.part"), UsageError) << key << " " << value;
  }
}

}  // namespace
}  // namespace lamella
