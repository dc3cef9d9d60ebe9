#include "analytic/facets/facet_integral.h"

#include <gtest/gtest.h>

#include "analytic/facets/cosine_table.h"
#include "phase/interface/dielectric.h"
#include "phase/surface/conductor.h"
#include "tests/analytic/model/nested_quadrature.h"

namespace lamella {
namespace {

constexpr FacetShape kShapes[] = {FacetShape::ggx, FacetShape::beckmann};
constexpr Masking kMaskings[] = {Masking::beta, Masking::correlated, Masking::separable};

double one(double) { return 1; }

double reflected(const Facets& facets, Masking masking, double ratio, Direction w) {
  return reflected_share<double>(
      facets, masking, w,
      [ratio](double cosine, Direction) {
        return refraction(std::fmin(cosine, 1), ratio).reflectance;
      },
      1e-7, critical_cosine(ratio));
}

TEST(FacetIntegral, ReflectedLightIsTheIntegralOfTheBsdf) {
  for (const FacetShape shape : kShapes)
    for (const auto& [x, y] : {std::pair{0.3, 0.3}, {0.9, 0.9}, {0.3, 0.8}})
      for (const double mu : {1.0, 0.5, 0.1}) {
        const Facets facets{shape, x, y};
        const Conductor gold({.facets = facets, .eta = Rgb(0.2, 1.5, 1), .k = Rgb(3, 0, 20)});
        const Direction wi = direction_from_mu_phi(mu, 0.7);
        const Rgb found = reflected_share<Rgb>(
            facets, Masking::beta, wi,
            [&](double cosine, Direction) { return gold.reflectance(std::fmin(cosine, 1)); });
        const Rgb right =
            integrate_projected_rgb([&](Direction wo) { return gold.single(wi, wo); }, 1, 1e-7);
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(found[c], right[c], 3e-7 * right[c])
              << to_text(shape) << ' ' << x << ' ' << y << ' ' << mu;
      }
}

// Three integrals over facets, of different integrands, whose sum is 1.
TEST(FacetIntegral, WhatIsReflectedRefractedAndLostIsAllThereIs) {
  double worst = 0;
  for (const FacetShape shape : kShapes)
    for (const double alpha : {1e-4, 0.1, 1.0})
      for (const double ratio : {1.0001, 1.5, 1 / 1.5})
        for (const Masking masking : kMaskings)
          for (const double mu : {0.6, 0.02, kGrazingLimit}) {
            const Facets facets{shape, alpha, alpha};
            const Direction w = direction_from_mu_phi(mu, 0);
            const double sum = reflected(facets, masking, ratio, w) +
                               refracted_share(facets, masking, ratio, w, one, 1e-6) +
                               lost_share(facets, masking, ratio, w, 1e-6);
            worst = std::max(worst, std::abs(sum - 1));
            EXPECT_NEAR(sum, 1, 5e-6) << to_text(shape) << ' ' << alpha << ' ' << ratio << ' '
                                      << to_text(masking) << ' ' << mu;
          }
  std::printf("worst: %g\n", worst);
}

TEST(FacetIntegral, TwoRoughnessesTurnWithTheFacets) {
  const Facets across{FacetShape::ggx, 0.2, 0.6}, along{FacetShape::ggx, 0.6, 0.2};
  EXPECT_NEAR(reflected(across, Masking::beta, 1.5, direction_from_mu_phi(0.4, 0.3)),
              reflected(along, Masking::beta, 1.5, direction_from_mu_phi(0.4, kPi / 2 - 0.3)),
              1e-9);
}

TEST(CosineTable, HoldsFunctionsThatChangeNearGrazing) {
  for (const double scale : {1.0, 0.01, 1e-4}) {
    const auto f = [scale](double mu) { return 1 / std::sqrt(mu * mu + scale * scale); };
    const CosineTable table(f, 13, scale / 4, 0.5);
    for (double mu = 1; mu > 1e-9; mu *= 0.83) EXPECT_NEAR(table(mu) / f(mu), 1, 1e-8) << mu;
    EXPECT_NEAR(table(0) / f(0), 1, 1e-8);
    EXPECT_NEAR(table.mean() / (2 * (std::sqrt(1 + scale * scale) - scale)), 1, 1e-8);
  }
}

}  // namespace
}  // namespace lamella
