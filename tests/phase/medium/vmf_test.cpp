#include "phase/medium/vmf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <limits>

#include "phase/math/clamped_cosines.h"
#include "phase/medium/lambert_sphere.h"
#include "tests/phase/medium/media_cases.h"
#include "tests/phase/medium/vmf_reference.h"

namespace lamella::testing {
namespace {

TEST(Vmf, SigmaMatchesAHighPrecisionQuadrature) {
  double worst = 0, worst_log = 0;
  for (const double alpha : {1e-6, 0.01, 0.05, 0.3, 1.0, 3.0, 30.0, 1e4})
    for (const double u : {-1.0, -0.6, -0.1, -3e-3, -1e-7, 0.0, 2e-3, 0.05, 0.5, 1.0}) {
      const Precise log_expected = reference_log_vmf_sigma(u, alpha);
      const double expected = static_cast<double>(Precise(exp(log_expected)));
      // As documented in vmf.h.
      if (log_expected > -690) {
        EXPECT_NEAR(vmf_sigma(u, alpha), expected, 1e-10 * expected) << alpha << ' ' << u;
        worst = std::max(worst, std::abs(vmf_sigma(u, alpha) / expected - 1));
      }
      const double l = static_cast<double>(log_expected);
      const double error = std::abs(log_vmf_sigma(u, alpha) - l);
      EXPECT_LE(error, 1e-11 * std::max(1.0, std::abs(l) * 1e-4)) << alpha << ' ' << u << ' ' << l;
      worst_log = std::max(worst_log, error / std::max(1.0, std::abs(l) * 1e-4));
    }
  RecordProperty("worst_relative_error", lamella::to_text(worst));
  RecordProperty("worst_log_error", lamella::to_text(worst_log));
}

TEST(Vmf, TableIsAsCloseToSigmaAsItSays) {
  double worst = 0;
  for (const double alpha : {1e-4, 0.01, 0.0321, 0.1, 0.25, 0.8, 2.0, 50.0, kInfinity}) {
    const Vmf ndf(alpha, {0, 0, 1});
    for (int k = -400; k <= 400; ++k) {
      const double u = k / 400.0 * (k % 2 ? 1 : std::min(1.0, 12 * alpha));
      const double error = std::abs(ndf.sigma(direction_from_mu_phi(u, 0.3)) - vmf_sigma(u, alpha));
      worst = std::max(worst, error);
      EXPECT_LE(error, 1e-12) << alpha << ' ' << u;
    }
  }
  RecordProperty("worst_error", lamella::to_text(worst));
}

TEST(Vmf, OddPartOfSigmaIsTheMeanCosine) {
  for (const double alpha : {0.01, 0.1, 0.5, 1.0, 3.0, 100.0})
    for (const double u : {0.01, 0.3, 0.7, 1.0})
      EXPECT_NEAR(vmf_sigma(u, alpha) - vmf_sigma(-u, alpha),
                  u * vmf_mean_cosine(vmf_concentration(alpha)), 2e-15)
          << alpha << ' ' << u;
}

TEST(Vmf, DensityIntegratesToOneAndItsMeanIsTheMeanNormal) {
  for (const double alpha : {0.01, 0.1, 1.0, 10.0}) {
    const Vmf ndf(alpha, kTilted);
    const auto moment = [&](auto weight) {
      return integrate_sphere([&](Direction m) { return weight(m) * ndf.density_of(m); },
                              {.axis = kTilted, .width = std::min(alpha, 1.0)}, 1e-11);
    };
    EXPECT_NEAR(moment([](Direction) { return 1.0; }), 1, 1e-9);
    EXPECT_NEAR(moment([](Direction m) { return dot(m, kTilted); }), length(ndf.mean_normal()),
                1e-9);
  }
}

TEST(Vmf, UniformNormalsHaveSigmaOneQuarter) {
  EXPECT_DOUBLE_EQ(vmf_sigma(0.3, kInfinity), 0.25);
  EXPECT_DOUBLE_EQ(vmf_alpha(1), kInfinity);
}

TEST(Vmf, LambertFlakesWithUniformNormalsAreLambertSpheresOfAQuarterOfTheDensity) {
  const LambertFlakes<Vmf> medium{Vmf(vmf_alpha(1), kTilted)};
  for (const Direction wi : incident_directions()) {
    EXPECT_NEAR(medium.sigma(wi), 0.25, 1e-15);
    for (const Direction wo : incident_directions())
      // The accuracy of the quadrature as documented.
      EXPECT_NEAR(medium.phase(wi, wo).density, lambert_sphere_phase(-dot(wi, wo)), 1e-8);
  }
}

TEST(Vmf, DiffusePhaseOfVeryNarrowFlakesContinuesTheQuadrature) {
  const Vmf below(0.999e-5, kTilted), above(1.001e-5, kTilted);
  const Direction edge = cross(kTilted, normalized(cross(kTilted, Direction{1, 0, 0})));
  for (const double u : {1.0, 0.3, 1e-3, 1e-5, 0.0, -1e-5, -3e-5}) {
    const Direction wi = normalized(u * kTilted + std::sqrt(1 - u * u) * edge);
    for (const Direction wo : incident_directions())
      EXPECT_NEAR(below.diffuse_phase(wi, wo), above.diffuse_phase(wi, wo), 2e-5)
          << u << ' ' << to_text(wo);
  }
}

TEST(Vmf, DeltaFlakesAreLambertsOwn) {
  const LambertFlakes<Vmf> medium{Vmf(vmf_alpha(0), {0, 0, 1})};
  EXPECT_EQ(medium.sigma(direction_from_mu_phi(0.3, 1)), 0.3);
  EXPECT_EQ(medium.sigma(direction_from_mu_phi(-0.3, 1)), 0);
  EXPECT_DOUBLE_EQ(
      medium.phase(direction_from_mu_phi(0.3, 1), direction_from_mu_phi(0.6, 2)).density,
      0.6 / kPi);
  EXPECT_TRUE(MirrorFlakes<Vmf>{medium.ndf}.is_delta());
  EXPECT_EQ(MirrorFlakes<Vmf>{medium.ndf}.phase({0, 0, 1}, {0, 0, 1}).density, 0);
}

// At the far back of narrow flakes sigma underflows; p does not.
TEST(Vmf, PhaseFunctionOfNarrowFlakesSeenFromBehindIsNormalised) {
  const MirrorFlakes<Vmf> medium{Vmf(0.02, {0, 0, 1})};
  const MediumCase c{"narrow", medium, {0, 0, 1}, 0.02};
  for (const double mu : {-1.0, -0.5, -0.05}) {
    const Direction wi = direction_from_mu_phi(mu, 0.4);
    const double sum = integrate_sphere([&](Direction wo) { return medium.phase(wi, wo).density; },
                                        lobe_cells(c, wi), 1e-4);
    // Three points a cell where each takes a quadrature; measured: 1.9e-3.
    EXPECT_NEAR(sum, 1, 3e-3) << mu;
  }
}

TEST(Vmf, DiffusePhaseMatchesAnAdaptiveQuadrature) {
  using boost::math::quadrature::gauss_kronrod;
  RandomStream stream(3, 0, StreamPurpose::test);
  const auto draw = [&] {
    const double mu = 2 * stream.uniform() - 1;
    return direction_from_mu_phi(mu, 2 * kPi * stream.uniform());
  };
  for (const double r : {0.1, 0.5, 0.9}) {
    const Vmf ndf(vmf_alpha(r), {0, 0, 1});
    const double kappa = vmf_concentration(ndf.alpha());
    for (int n = 0; n < 20; ++n) {
      const Direction wi = draw(), wo = draw();
      const ClampedCosines pair(wi, wo, {0, 0, 1});
      const auto integrand = [&](double v) { return vmf_density(kappa, v) * pair.overlap(v); };
      std::vector<double> edges{-1, 1};
      for (const double kink : pair.kinks()) edges.insert(edges.end(), {kink, -kink});
      std::sort(edges.begin(), edges.end());
      double integral = 0;
      for (std::size_t k = 0; k + 1 < edges.size(); ++k)
        if (edges[k + 1] > edges[k])
          integral +=
              gauss_kronrod<double, 21>::integrate(integrand, edges[k], edges[k + 1], 12, 1e-12);
      const double expected = integral / (kPi * vmf_sigma(wi.z, ndf.alpha()));
      EXPECT_NEAR(ndf.diffuse_phase(wi, wo), expected, 1e-7 * expected + 1e-14) << r;
    }
  }
}

}  // namespace
}  // namespace lamella::testing
