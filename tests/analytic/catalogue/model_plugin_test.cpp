#include "analytic/catalogue/model_plugin.h"

#include <gtest/gtest.h>

#include "tests/analytic/model/model_checks.h"

namespace lamella {
namespace {

std::string object(const std::string& name) {
  return std::string(LAMELLA_PLUGINS) + "/" + name + ".so";
}

std::unique_ptr<Model> minnaert(double k, Rgb albedo = Rgb(1)) {
  const ModelInfo& info = load_model_plugin(object("minnaert"));
  Parameters p;
  p.set("albedo", albedo);
  p.set("k", k);
  return info.make(p, nullptr);
}

std::string refusal(const std::string& name) {
  try {
    const ModelInfo& info = load_model_plugin(object(name));
    Parameters p;
    fill_defaults(info.parameters, p);
    (void)info.make(p, nullptr)->eval({0, 0, 1}, {0, 0, 1});
  } catch (const std::exception& error) {
    return error.what();
  }
  return "none";
}

TEST(ModelPlugin, TheExampleIsAModelLikeAnyOther) {
  const ModelInfo& info = load_model_plugin(object("minnaert"));
  EXPECT_EQ(info.name, "minnaert");
  EXPECT_EQ(&info, find_or_load_model(object("minnaert")));
  ASSERT_EQ(info.parameters.size(), 2u);
  EXPECT_EQ(info.parameters[1].default_value, "0.9");
  const auto model = minnaert(0.8, Rgb(1, 0.5, 0));
  testing::expect_sane_values(*model, 1);
  testing::expect_reciprocal(*model);
  testing::expect_albedo_equals_quadrature(*model);
  testing::expect_sampler_follows_its_pdf("minnaert", *model, 1e-6);
  EXPECT_NEAR(minnaert(1)->eval({0, 0, 1}, {0.6, 0, 0.8}).g, 1 / kPi, 1e-15);
}

TEST(ModelPlugin, BrokenObjectsAreRefusedWithWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"no_symbol", "symbol \"lamella_model_v1\": found nothing; allowed: a constant of type"},
      {"wrong_version", "version: found 7; allowed: 1"},
      {"no_eval", "eval: found nothing; allowed: a function"},
      {"not_a_number", "lobe \"diffuse\": found nan at w_i = (0, 0, 1)"},
      {"negative", "lobe \"diffuse\": found -0.25 at w_i = (0, 0, 1)"},
      {"silent", "lobe \"diffuse\": found nan"},
      {"absent", "cannot be loaded"}};
  for (const auto& [name, text] : cases) {
    const std::string found = refusal(name);
    EXPECT_NE(found.find(text), std::string::npos) << name << ": " << found;
    EXPECT_NE(found.find(object(name)), std::string::npos) << found;
    EXPECT_EQ(found.find('\n'), std::string::npos) << found;
  }
}

}  // namespace
}  // namespace lamella
