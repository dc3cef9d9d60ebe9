#include "analytic/catalogue/model_plugin.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

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

std::unique_ptr<Model> facets(const std::string& precision, double alpha, double roughness) {
  const ModelInfo& info = load_model_plugin(object(precision));
  Parameters p;
  p.set("albedo", Rgb(0.9, 0.5, 0.1));
  p.set("alpha", alpha);
  p.set("roughness", roughness);
  fill_defaults(info.parameters, p);
  return info.make(p, nullptr);
}

TEST(ModelPlugin, InSinglePrecisionAlbedosEndWithTheirError) {
  for (const double alpha : {0.01, 0.3, 1.0})
    for (const double roughness : {0.0, 0.7})
      for (const double theta : {0.0, 45.0, 89.0, 90.0}) {
        SCOPED_TRACE(::testing::Message() << alpha << ' ' << roughness << ' ' << theta);
        const Direction wi = with_grazing_limit(direction_from_degrees(theta, 30));
        const AlbedoEstimate found =
            facets("single_precision", alpha, roughness)->albedo_with_error(wi);
        const AlbedoEstimate right =
            facets("double_precision", alpha, roughness)->albedo_with_error(wi);
        for (int c = 0; c < 3; ++c) {
          EXPECT_LE(std::abs(found.value[c] - right.value[c]), found.error[c] + right.error[c]);
          // A facet's density amplifies rounding by 1 / alpha^2.
          EXPECT_LT(found.error[c], 1e-6 + 2e-6 / (alpha * alpha)) << c;
          EXPECT_LT(right.error[c], 1e-7) << c;
        }
      }
}

std::unique_ptr<Model> hostile(int kind) {
  const ModelInfo& info = load_model_plugin(object("hostile"));
  Parameters p;
  p.set("kind", static_cast<double>(kind));
  return info.make(p, nullptr);
}

TEST(ModelPlugin, WhateverItsValuesAlbedosEndWithTheirError) {
  const Direction wi = direction_from_degrees(40, 20);
  const auto albedo = [&](int kind) { return hostile(kind)->albedo_with_error(wi); };
  const auto expect = [](const AlbedoEstimate& found, double right, double most) {
    EXPECT_LE(std::abs(found.value.g - right), found.error.g);
    EXPECT_LT(found.error.g, most);
  };
  const AlbedoEstimate noise = albedo(0);
  expect(noise, 1, 0.5);
  EXPECT_EQ(noise.end, IntegralEnd::noise);
  const double half = 0.5 + 0.15 / std::sqrt(1.09);
  expect(albedo(1), half, 1e-3);
  const AlbedoEstimate endless = albedo(2);
  EXPECT_NE(endless.end, IntegralEnd::tolerance);
  EXPECT_GT(endless.error.g, 1e-2 * endless.value.g);
  expect(albedo(3), 1, 1e-4);
  for (const int kind : {4, 5, 6}) {
    try {
      (void)albedo(kind);
      ADD_FAILURE() << kind;
    } catch (const std::domain_error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  const AlbedoEstimate checkered = albedo(7);
  EXPECT_LE(std::abs(checkered.value.g - 0.5), checkered.error.g);
  EXPECT_NE(checkered.end, IntegralEnd::tolerance);
  const AlbedoEstimate spike = hostile(9)->albedo_with_error({0, 0, 1});
  EXPECT_LE(std::abs(spike.value.g - 1), spike.error.g);
}

TEST(ModelPlugin, SlowModelsEndByTime) {
  const auto start = std::chrono::steady_clock::now();
  const AlbedoEstimate slow = hostile(8)->albedo_with_error(direction_from_degrees(40, 20));
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(slow.end, IntegralEnd::time);
  EXPECT_LE(std::abs(slow.value.g - (0.5 + 0.15 / std::sqrt(1.09))), slow.error.g);
  // The limit of 10 s, after the first pass over the sphere: some 6000 values.
  EXPECT_LT(taken.count(), 120);
}

}  // namespace
}  // namespace lamella
