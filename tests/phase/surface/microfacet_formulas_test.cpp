// The formulas that walks on lanes take from phase/surface, in double: against the surfaces and the
// equations that the scalar walk takes.
#include "phase/surface/microfacet_formulas.h"

#include <gtest/gtest.h>

#include <cmath>

#include "phase/math/direction.h"
#include "phase/surface/fresnel_formulas.h"
#include "phase/surface/microfacet.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

const double kCosinesAbove[] = {1, 0.8, 0.3, 0.05, 1e-3};

SphereCells normals_about_z(const Facets& f) {
  return {.axis = {0, 0, 1}, .width = std::min(f.alpha_x, f.alpha_y)};
}

SineCosine<double> azimuth_from(double u) { return sine_cosine_of_half_turns(2 * u - 1); }

TEST(FacetFormulas, AreasAreThoseOfTheSurface) {
  for (const auto& [ax, ay] :
       {std::pair{1e-4, 1e-4}, {0.05, 0.05}, {0.3, 0.3}, {1.0, 1.0}, {0.2, 0.6}})
    for (const double mu : kCosinesAbove) {
      const Direction w = direction_from_mu_phi(mu, 0.4);
      const Facets ggx{FacetShape::ggx, ax, ay}, beckmann{FacetShape::beckmann, ax, ay};
      const GgxFacets<double> g{ax, ay};
      EXPECT_NEAR(g.hidden_area(w), ggx.area(-w), 1e-15);
      EXPECT_NEAR(g.visible(w, azimuth_from(0.3), 0.4).seen, ggx.area(w), 1e-15);
      const BeckmannFacets<double> b{ax, ay};
      EXPECT_NEAR(b.hidden_area(w), beckmann.area(-w), 1e-15) << ax << ' ' << mu;
      EXPECT_NEAR(w.z + b.hidden_area(w), beckmann.area(w), 1e-15);
    }
}

TEST(FacetFormulas, VisibleNormalsFollowTheirDensity) {
  for (const FacetShape shape : {FacetShape::ggx, FacetShape::beckmann})
    for (const auto& [ax, ay] : {std::pair{0.05, 0.05}, {0.3, 0.3}, {1.0, 1.0}, {0.2, 0.6}})
      for (const double mu : kCosinesAbove) {
        const Facets f{shape, ax, ay};
        const Direction w = direction_from_mu_phi(mu, 0.4);
        const auto sample = [&](RandomStream& stream) {
          const double u1 = stream.uniform(), u2 = stream.uniform();
          if (shape == FacetShape::ggx)
            return GgxFacets<double>{f.alpha_x, f.alpha_y}.visible(w, azimuth_from(u1), u2).m;
          const BeckmannFacets<double> b{f.alpha_x, f.alpha_y};
          const double u3 = stream.uniform(), u4 = stream.uniform();
          return b.visible_normal(b.seen_by(w), azimuth_from(u1), -std::log(u2), u3, u4);
        };
        EXPECT_GE(
            sampler_p_value(
                std::string(to_text(shape)) + " from " + std::to_string(mu), normals_about_z(f),
                sample, [&](Direction m) { return f.visible_density(w, m); }, 60000),
            test_level())
            << to_text(shape) << ' ' << ax << ' ' << mu;
      }
}

TEST(FresnelFormulas, TheFormWithoutDifferencesIsTheSame) {
  for (const double ior : {0.3, 0.7, 0.9999, 1.0001, 1.33, 1.5, 3.0})
    for (const double cosine : {1.0, 0.9, 0.5, 0.1, 1e-3, 1e-7, 0.0}) {
      const Refraction<double> a = refraction(cosine, ior);
      const Refraction<double> b = refraction(cosine, ior, 1 / ior, (ior - 1) * (ior + 1));
      EXPECT_NEAR(b.reflectance, a.reflectance, 1e-12 * a.reflectance + 1e-16)
          << ior << ' ' << cosine;
      EXPECT_NEAR(b.cosine, a.cosine, 1e-15) << ior << ' ' << cosine;
    }
}

}  // namespace
}  // namespace lamella::testing
