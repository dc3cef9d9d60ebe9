#include "phase/interface/dielectric.h"

#include <gtest/gtest.h>

#include "phase/math/direction.h"
#include "phase/math/sampling.h"
#include "tests/phase/interface/facet_energies.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

std::vector<Dielectric> rough_ones() {
  std::vector<Dielectric> list;
  for (const FacetShape shape : {FacetShape::ggx, FacetShape::beckmann})
    for (const auto& [x, y] : {std::pair{0.1, 0.1}, {0.6, 0.6}, {0.2, 0.5}})
      for (const double below : {1.5, 1 / 1.3})
        list.push_back({.facets = {shape, x, y}, .above = 1, .below = below});
  return list;
}

std::string name_of(const Dielectric& d) {
  return std::string(to_text(d.facets.shape)) + ' ' + std::to_string(d.facets.alpha_x) + ' ' +
         std::to_string(d.facets.alpha_y) + ' ' + std::to_string(d.below);
}

TEST(Dielectric, SingleScatteringSamplesItsEnergies) {
  for (Dielectric d : rough_ones())
    for (const Masking masking : {Masking::beta, Masking::correlated, Masking::separable})
      for (const double mu : {0.9, 0.1, -0.7, -0.2}) {
        d.masking = masking;
        const Direction wi = direction_from_mu_phi(mu, 0.3);
        RandomStream stream(1, 0, StreamPurpose::test);
        std::vector<double> reflected(20000), transmitted(reflected.size());
        for (std::size_t n = 0; n < reflected.size(); ++n) {
          const auto s = d.scatter(wi, stream);
          ASSERT_GE(s.kept, 0);
          ASSERT_LE(s.kept, 1 + 1e-14);
          (s.wo.z * wi.z > 0 ? reflected : transmitted)[n] = s.kept;
        }
        // The midpoint rule is good to some 1e-4 at the edges of total reflection, below the noise.
        const FacetEnergies exact = facet_energies(d, wi, 150);
        EXPECT_GE(mean_p_value(reflected, exact.reflected), test_level())
            << name_of(d) << ' ' << to_text(masking) << ' ' << mu;
        EXPECT_GE(mean_p_value(transmitted, exact.transmitted), test_level())
            << name_of(d) << ' ' << to_text(masking) << ' ' << mu;
      }
}

// f |mu_o| and the sampler's density over the sphere of w_o, against the integral over facets.
TEST(Dielectric, SingleScatteringIntegratesToItsEnergies) {
  for (const Dielectric& d : rough_ones()) {
    if (d.facets.alpha_x < 0.2) continue;
    for (const double mu : {0.8, -0.6}) {
      const Direction wi = direction_from_mu_phi(mu, 0.3);
      const SphereCells cells{.axis = {0, 0, 1}, .rows = 40, .columns = 40, .smooth = true};
      const auto f = [&](Direction wo) { return d.single(wi, wo) * std::abs(wo.z); };
      const auto side = [&](double sign) {
        return integrate_sphere([&](Direction wo) { return wo.z * sign > 0 ? f(wo) : 0; }, cells);
      };
      const FacetEnergies exact = facet_energies(d, wi, 150);
      // Edges of the refracted lobe (GGX at m.z = 0) and total reflection cost a fixed rule digits.
      EXPECT_NEAR(side(mu), exact.reflected, 2e-3) << name_of(d) << ' ' << mu;
      EXPECT_NEAR(side(-mu), exact.transmitted, 2e-3) << name_of(d) << ' ' << mu;
    }
  }
}

TEST(Dielectric, SamplesFollowTheirDensity) {
  for (const Dielectric& d : rough_ones())
    for (const double mu : {0.8, -0.6}) {
      if (d.facets.alpha_x != 0.2) continue;  // quadrature over a density takes seconds
      const Direction wi = direction_from_mu_phi(mu, 0.3);
      RandomStream stream(7, 0, StreamPurpose::test);
      // Redrawn where it goes to the wrong side: then the density is of what is left.
      int tries = 0, good = 0;
      const auto sample = [&](RandomStream& s) {
        for (;;) {
          const auto out = d.scatter(wi, s);
          ++tries;
          if (out.kept > 0) return ++good, out.wo;
        }
      };
      for (int n = 0; n < 200000; ++n) (void)sample(stream);
      const double left = static_cast<double>(good) / tries;  // to 1e-3
      const Direction lobe = mu > 0 ? direction_from_mu_phi(mu, kPi + 0.3) : Direction{0, 0, -1};
      EXPECT_GE(sampler_p_value(
                    name_of(d), {.axis = lobe, .width = 0.4}, sample,
                    [&](Direction wo) { return d.single_density(wi, wo) / left; }, 20000),
                test_level())
          << name_of(d) << ' ' << mu;
    }
}

TEST(Dielectric, ReciprocityWithTheSquareOfTheIndex) {
  for (Dielectric d : rough_ones())
    for (const Masking masking : {Masking::beta, Masking::correlated, Masking::separable}) {
      d.masking = masking;
      RandomStream stream(8, 0, StreamPurpose::test);
      for (int n = 0; n < 200; ++n) {
        const auto draw = [&] {
          const double mu = 2 * stream.uniform() - 1, phi = 2 * kPi * stream.uniform();
          return direction_from_mu_phi(mu, phi);
        };
        const Direction wi = draw(), wo = draw();
        const double there = d.single(wi, wo) / (d.index(wo) * d.index(wo));
        const double back = d.single(wo, wi) / (d.index(wi) * d.index(wi));
        EXPECT_NEAR(there, back, 1e-9 * (there + back) + 1e-300);
      }
    }
}

TEST(Dielectric, EveryReflectionBetweenFacetsConservesEnergyAndBeginsWithSingle) {
  for (Dielectric d : rough_ones()) {
    const Dielectric single = d;
    d.multiple = true;
    for (const auto& [mi, mo] : {std::pair{0.5, 0.6}, {0.5, -0.6}, {-0.8, 0.7}, {-0.8, -0.7}}) {
      const Direction wi = direction_from_mu_phi(mi, 0), wo = direction_from_mu_phi(mo, 2.8);
      RandomStream stream(9, 0, StreamPurpose::test);
      const double first = single.single(wi, wo);
      double sum = 0;
      constexpr int kCount = 4000;
      for (int n = 0; n < kCount; ++n) {
        const double f = d.eval(wi, wo, stream);
        ASSERT_GE(f, 0);
        sum += f;
        EXPECT_EQ(d.scatter(wi, stream).kept, 1);
      }
      // Further reflections only add; sum / n has an error of a few per cent.
      EXPECT_GE(sum / kCount, 0.9 * first) << name_of(d) << ' ' << mi << ' ' << mo;
    }
  }
}

// One facet at a time: the estimate's first term, averaged over the height of the first facet, is
// single scattering with the Beta function.
TEST(Dielectric, EstimatesOfEveryReflectionAreWhatIsSampled) {
  const Dielectric d{.facets = {FacetShape::ggx, 0.6, 0.6}, .multiple = true, .below = 1.5};
  for (const double mi : {0.7, -0.7, 0.05})
    for (const double side : {1.0, -1.0}) {
      const Direction wi = direction_from_mu_phi(mi, 0);
      RandomStream stream(10, 0, StreamPurpose::test);
      constexpr int kCount = 100000;
      double a = 0, b = 0, va = 0, vb = 0;
      for (int n = 0; n < kCount; ++n) {
        const Direction out = d.scatter(wi, stream).wo;
        const double v = out.z * side > 0.3 ? 1 : 0;
        a += v, va += v * v;
        const double mu = 0.3 + 0.7 * stream.uniform(), phi = 2 * kPi * stream.uniform();
        const double e =
            d.eval(wi, direction_from_mu_phi(side * mu, phi), stream) * mu * 0.7 * 2 * kPi;
        b += e, vb += e * e;
      }
      a /= kCount, b /= kCount;
      const double se = std::sqrt((va / kCount - a * a + vb / kCount - b * b) / kCount);
      EXPECT_LT(std::abs(a - b) / se, normal_quantile(test_level())) << mi << ' ' << side;
    }
}

// At alpha 0.6, mu 0.05, n 1.5 from above, T of single scattering by masking term.
TEST(Dielectric, MaskingTermsDifferAsMeasured) {
  Dielectric d{.facets = {FacetShape::ggx, 0.6, 0.6}, .below = 1.5};
  const Direction wi = direction_from_mu_phi(0.05, 0);
  d.masking = Masking::separable;
  EXPECT_NEAR(facet_energies(d, wi, 150).transmitted, 0.510, 2e-3);
  d.masking = Masking::correlated;
  EXPECT_NEAR(facet_energies(d, wi, 150).transmitted, 0.764, 2e-3);
  d.masking = Masking::beta;
  EXPECT_NEAR(facet_energies(d, wi, 150).transmitted, 0.257, 2e-3);
}

TEST(Dielectric, SmoothScattersByFresnel) {
  const Dielectric d{.facets = {.shape = FacetShape::smooth}, .above = 1, .below = 1.5};
  for (const double mu : {1.0, 0.3, -0.9, -0.5}) {
    const Direction wi = direction_from_mu_phi(mu, 0.2);
    RandomStream stream(11, 0, StreamPurpose::test);
    std::vector<double> reflected(20000);
    for (double& v : reflected) {
      const auto s = d.scatter(wi, stream);
      EXPECT_EQ(s.kept, 1);
      v = s.wo.z * wi.z > 0;
      EXPECT_NEAR(d.index(s.wo) * s.wo.x, -d.index(wi) * wi.x, 1e-14);
    }
    EXPECT_GE(mean_p_value(reflected, d.smooth_refraction(wi).reflectance),
              d.smooth_refraction(wi).cosine > 0 ? test_level() : 0);
  }
}

}  // namespace
}  // namespace lamella::testing
