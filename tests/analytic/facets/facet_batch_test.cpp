// Facets on lanes of double, on every instruction set that the machine has, against the same in
// double.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "analytic/facets/facet_formula.h"
#include "phase/random/random.h"
#include "tests/analytic/model/model_checks.h"

namespace lamella {
namespace {

using testing::make_model;

struct FacetCase {
  std::string what;
  double alpha;
  bool dielectric;
  std::vector<std::pair<std::string, ParameterValue>> values;
};

std::vector<FacetCase> facet_cases() {
  std::vector<FacetCase> list;
  for (const char* distribution : {"ggx", "beckmann"})
    for (const char* masking : {"beta", "separable", "correlated"})
      for (const double alpha : {1e-3, 0.1, 1.0})
        for (const auto& material : {"conductor", "white", "1.5", "0.6", "3"}) {
          const bool dielectric = material[0] < 'a';
          FacetCase c{
              std::string(distribution) + ' ' + masking + ' ' + material, alpha, dielectric, {}};
          c.values = {{"distribution", std::string(distribution)},
                      {"masking", std::string(masking)},
                      {"roughness", alpha},
                      {"roughness_y", alpha > 0.5 ? 0.3 : 0.0},
                      {"material", std::string(dielectric ? "dielectric" : material)}};
          if (dielectric) c.values.push_back({"ior", std::stod(material)});
          list.push_back(c);
        }
  return list;
}

std::vector<DirectionPair> facet_pairs(double alpha) {
  std::vector<Direction> special{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}};
  for (const double mu : {1 - 1e-8, 0.5, 1e-3, 1e-8, 1e-12, 1e-100, -1e-8, -0.5})
    for (const double phi : {0.0, 2.0, kPi}) special.push_back(direction_from_mu_phi(mu, phi));
  std::vector<DirectionPair> pairs;
  for (const Direction wi : special)
    for (const Direction wo : special)
      if (wi.z != 0 || wo.z != 0) pairs.push_back({wi, wo});
  RandomStream stream(1, 0, StreamPurpose::test);
  const auto draw = [&] {
    return direction_from_mu_phi(2 * stream.uniform() - 1, 2 * kPi * stream.uniform());
  };
  for (int k = 0; k < 1500; ++k) {
    const Direction wi = draw();
    pairs.push_back({wi, draw()});
    // Near the mirror direction, where narrow facets are.
    const Direction off = draw();
    const Direction wo{-wi.x + 3 * alpha * off.x, -wi.y + 3 * alpha * off.y, wi.z};
    pairs.push_back({wi, normalized(wo)});
  }
  return pairs;
}

class FacetBatch : public ::testing::TestWithParam<Isa> {};

// Rounding of a facet's slope, 1e-16, moves D by 1e-16 slope / alpha times a few; what is exp(-x)
// for large x by x of that. The largest f of facets, 1 / (4 pi alpha^2 mu^2), sets the scale where
// D itself is nothing. Towards the critical angle, and where the refracted light grazes the facet,
// f falls to 0 in proportion to a difference of numbers of order n^2 <= 9.
TEST_P(FacetBatch, DiffersFromDoubleByRounding) {
  double worst = 0;
  for (const FacetCase& c : facet_cases()) {
    SCOPED_TRACE(c.what + ' ' + std::to_string(c.alpha));
    const auto model = make_model("microfacet", c.values);
    const std::vector<DirectionPair> pairs = facet_pairs(c.alpha);
    std::vector<Rgb> values(pairs.size());
    model->eval(pairs, values, GetParam());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto [wi, wo] = pairs[k];
      const Rgb single = model->eval(wi, wo);
      for (int channel = 0; channel < 3; ++channel) {
        const double f = single[channel];
        const double least = (c.dielectric ? 1e-14 : 1e-16) / (c.alpha * c.alpha);
        const double allowed = (1e-13 + 1e-14 / c.alpha) * f + least;
        const double off = std::abs(values[k][channel] - f);
        EXPECT_LE(off, allowed) << wi.z << ' ' << wo.z << ' ' << f << ' ' << values[k][channel];
        if (f > 0) worst = std::max(worst, off / allowed);
      }
    }
  }
  std::printf("%s: at most %.2g of what is allowed\n", to_text(GetParam()).c_str(), worst);
}

TEST_P(FacetBatch, WhatTakesTablesIsEvaluatedPairByPair) {
  const auto model = make_model("microfacet", {{"compensation", std::string("kulla_conty")}});
  const std::vector<DirectionPair> pairs = facet_pairs(0.3);
  std::vector<Rgb> values(pairs.size());
  model->eval(pairs, values, GetParam());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    EXPECT_EQ(values[k], model->eval(pairs[k].wi, pairs[k].wo));
}

INSTANTIATE_TEST_SUITE_P(AllSets, FacetBatch, ::testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return to_text(isa.param); });

TEST(FacetFormula, BetaFunctionKeepsItsDigits) {
  // B(1, b) = 1 / b, B(2, b) = 1 / (b (b + 1)). The exponent is rounded: up to 9.5 log(1e14) twice.
  constexpr double kRounding = 7e-14;
  for (const double b : {1.0, 1.5, 7.0, 1e3, 1e8, 1e14}) {
    EXPECT_NEAR(FacetFormula::beta(1.0, b) * b, 1, kRounding) << b;
    EXPECT_NEAR(FacetFormula::beta(2.0, b) * b * (b + 1), 1, kRounding) << b;
    EXPECT_EQ(FacetFormula::beta(b, 2.0), FacetFormula::beta(2.0, b));
  }
  EXPECT_NEAR(FacetFormula::beta(1.5, 1.5), kPi / 8, 1e-15);
  EXPECT_NEAR(FacetFormula::beta(5.5, 3.25) / std::beta(5.5, 3.25), 1, 1e-14);
}

}  // namespace
}  // namespace lamella
