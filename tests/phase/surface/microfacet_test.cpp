#include "phase/surface/microfacet.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/beta.hpp>
#include <cmath>

#include "phase/math/direction.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

std::vector<Facets> surfaces() {
  std::vector<Facets> list;
  for (const FacetShape shape : {FacetShape::ggx, FacetShape::beckmann})
    for (const auto& [x, y] : {std::pair{0.05, 0.05}, {0.3, 0.3}, {1.0, 1.0}, {0.2, 0.6}})
      list.push_back({shape, x, y});
  return list;
}

std::string name_of(const Facets& f) {
  return std::string(to_text(f.shape)) + ' ' + std::to_string(f.alpha_x) + ' ' +
         std::to_string(f.alpha_y);
}

// Normals of a surface gather about z within alpha.
SphereCells about_z(const Facets& f) {
  return {.axis = {0, 0, 1}, .width = std::min(f.alpha_x, f.alpha_y)};
}

const double kFacetCosines[] = {1, 0.8, 0.3, 0.05, -0.05, -0.3};

TEST(Facets, ProjectedDensityIsOne) {
  for (const Facets& f : surfaces())
    EXPECT_NEAR(integrate_sphere([&](Direction m) { return f.density(m) * nonnegative(m.z); },
                                 about_z(f), 1e-9),
                1, 1e-7)
        << name_of(f);
}

TEST(Facets, AreaIsWhatTheyShow) {
  for (const Facets& f : surfaces())
    for (const double mu : {0.8, 0.05, -0.3}) {
      const Direction w = direction_from_mu_phi(mu, 0.4);
      // GGX has an edge at m.z = 0, which costs the quadrature digits.
      const double shown = integrate_sphere(
          [&](Direction m) { return f.density(m) * nonnegative(dot(w, m)); }, about_z(f), 1e-5);
      EXPECT_NEAR(f.area(w), shown, 3e-5) << name_of(f) << ' ' << mu;
      EXPECT_NEAR(f.area(w) - f.area(-w), w.z, 1e-15) << name_of(f) << ' ' << mu;
    }
}

TEST(Facets, VisibleNormalsFollowTheirDensity) {
  for (const Facets& f : surfaces())
    for (const double mu : kFacetCosines) {
      const Direction w = direction_from_mu_phi(mu, 0.4);
      if (f.area(w) < 1e-6) continue;
      const auto sample = [&](RandomStream& stream) {
        const double u1 = stream.uniform(), u2 = stream.uniform();
        return f.visible_normal(w, u1, u2);
      };
      EXPECT_GE(sampler_p_value(
                    name_of(f) + " from " + std::to_string(mu), about_z(f), sample,
                    [&](Direction m) { return f.visible_density(w, m); }, 60000),
                test_level())
          << name_of(f) << ' ' << mu;
    }
}

TEST(Facets, ShadowingHasItsLimits) {
  for (const Facets& f : surfaces())
    for (const Masking masking : {Masking::beta, Masking::correlated, Masking::separable})
      for (const bool transmission : {false, true}) {
        const Direction up = direction_from_mu_phi(0.7, 0.1);
        for (const double mu : {1.0, 0.5, 0.1, 1e-3}) {
          const Direction w = direction_from_mu_phi(mu, 2);
          const double a = f.area(up) / up.z, b = f.area(w) / w.z;  // 1 + Lambda
          const double g = masking == Masking::separable ? 1 / (a * b)
                           : masking == Masking::correlated || !transmission
                               ? 1 / (a + b - 1)
                               : boost::math::beta(a, b);
          EXPECT_NEAR(f.shadowing(masking, transmission, up, w) * up.z * mu, g, 1e-12 * g);
          EXPECT_NEAR(f.passes(masking, transmission, up, w), g * a, 1e-12 * g * a);
          EXPECT_LE(f.passes(masking, transmission, up, w), 1 + 1e-15);
        }
        // At grazing the value is finite, and the same as next to it.
        const Direction limit = with_grazing_limit({1, 0, 0}),
                        near = direction_from_mu_phi(1e-12, 0);
        const double at = f.shadowing(masking, transmission, up, limit);
        EXPECT_TRUE(std::isfinite(at));
        EXPECT_TRUE(std::isfinite(f.shadowing(masking, transmission, limit, limit)) ||
                    masking != Masking::beta);
        if (masking != Masking::beta || !transmission) {
          EXPECT_NEAR(at, f.shadowing(masking, transmission, up, near), 1e-6 * at);
        }
      }
}

// At a far end of Lambda the Beta function has a limit of its own: the two forms meet.
TEST(Facets, BetaFunctionMeetsItsLimit) {
  const Facets f{FacetShape::ggx, 0.3, 0.3};
  const Direction up = direction_from_mu_phi(0.7, 0.1);
  const double before = f.shadowing(Masking::beta, true, up, direction_from_mu_phi(2e-16, 0));
  const double after = f.shadowing(Masking::beta, true, up, direction_from_mu_phi(1e-16, 0));
  const double power = f.area(up) / up.z;
  EXPECT_NEAR(after / before, std::pow(0.5, power - 1), 1e-9);
}

}  // namespace
}  // namespace lamella::testing
