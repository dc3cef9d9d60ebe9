#include "compare/request/model_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/request/errors.h"

namespace lamella {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(ModelRequest, IsTheSameAsOneTextAndAsWords) {
  const ModelRequest text = parse_model_request("eon,roughness=0.3,albedo=0.9,0.5,0.2");
  const ModelRequest words = parse_model_words({"eon", "roughness=0.3", "albedo=0.9,0.5,0.2"});
  for (const ModelRequest& request : {text, words}) {
    EXPECT_EQ(request.name, "eon");
    EXPECT_THAT(request.values,
                ElementsAre(Pair("roughness", "0.3"), Pair("albedo", "0.9,0.5,0.2")));
  }
}

TEST(ModelRequest, IsToldApartByWhatWasGivenAndDiffers) {
  std::vector<BoundModel> models;
  for (const char* text : {"eon,roughness=0.5,albedo=0.5", "lambert", "eon,albedo=0.5", "lambert",
                           "hapke_lambert_sphere"})
    models.push_back(bind_model(parse_model_request(text), nullptr));
  const auto roughness = [&](std::size_t k) {
    return "eon, roughness=" + request_value(models[k].parameters.at("roughness"));
  };
  if (roughness(0) == roughness(2)) models[2].parameters.set("roughness", 0.25);
  EXPECT_THAT(distinct_labels(models), ElementsAre(roughness(0), "lambert, 1", roughness(2),
                                                   "lambert, 2", "hapke_lambert_sphere"));
}

TEST(ModelRequest, KeepsFurtherEqualSignsInTheValue) {
  EXPECT_THAT(parse_model_words({"eon", "a=b=c"}).values, ElementsAre(Pair("a", "b=c")));
}

TEST(ModelRequest, RefusesWordsWithoutAKey) {
  EXPECT_THROW((void)parse_model_request("eon,0.3"), UsageError);
  try {
    (void)parse_model_words({"eon", "roughness=0.3", "rough"});
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "eon: found \"rough\"; allowed: key=value");
  }
}

}  // namespace
}  // namespace lamella
