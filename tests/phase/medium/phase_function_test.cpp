#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <boost/math/quadrature/gauss.hpp>

#include "phase/medium/flake.h"
#include "tests/phase/medium/media_cases.h"

namespace lamella::testing {
namespace {

Direction any_direction() {
  const auto unit =
      rc::gen::map(rc::gen::inRange(0, 1 << 24), [](int k) { return (k + 0.5) / (1 << 24); });
  return uniform_sphere(*unit, *unit);
}

double any_number(double from, double to) {
  return from + (to - from) * *rc::gen::inRange(0, 1 << 24) / ((1 << 24) - 1.0);
}

// |sigma_i p(wi -> wo) - sigma_o p(wo -> wi)| against the larger of both; quadratures tell nothing
// of values that are nothing beside the lobe.
void expect_reciprocal(const Medium& medium, Direction wi, Direction wo, double tolerance) {
  const double si = sigma(medium, wi), so = sigma(medium, wo);
  const double forth = si * phase(medium, wi, wo).density;
  const double back = so * phase(medium, wo, wi).density;
  EXPECT_NEAR(forth, back, tolerance * std::max(forth, back) + 1e-12)
      << to_text(wi) << ' ' << to_text(wo);
}

TEST(PhaseFunction, IntegratesToOneForEveryMediumAndDirection) {
  for (const MediumCase& c : media_cases()) {
    if (c.costly) continue;
    for (const Direction wi : incident_directions()) {
      if (!scatters(c, wi)) continue;
      const SphereCells cells = lobe_cells(c, wi);
      const double sum = integrate_sphere(
          [&](Direction wo) { return phase(c.medium, wi, wo).density; }, cells, 1e-5);
      // Of the quadrature, which meets the jump of D(h) at w_o = -w_i (measured: 3e-5), or has
      // three points a cell (1.9e-3).
      EXPECT_NEAR(sum, 1, cells.smooth ? 3e-3 : 1e-4) << c.name << ' ' << to_text(wi);
    }
  }
}

// What an event prepares for many directions, straight on and back included, and where sigma is
// next to nothing.
TEST(PhaseFunction, OfAnEventForManyDirectionsIsThatOfOne) {
  for (const MediumCase& c : media_cases()) {
    for (const Direction wi : incident_directions()) {
      if (!scatters(c, wi)) continue;
      std::visit(
          [&](const auto& medium) {
            RandomStream stream(1, 2, StreamPurpose::measure);
            const auto event = medium.collide(wi, stream);
            const auto& lobe = lobe_of(event);
            for (int k = 0; k < 40; ++k) {
              const Direction wo = k == 0   ? -wi
                                   : k == 1 ? wi
                                   : k < 20 ? event.sample(stream).wo
                                            : uniform_sphere(stream.uniform(), stream.uniform());
              const PhaseValue one = event.density(wo), many = lobe.density(wo);
              // Next to w_o = -w_i rounding decides where h points.
              const Direction h = wi + wo;
              const double rounding = 1e-12 * (1 + 1e-3 / std::max(dot(h, h), 1e-12)) *
                                      (1 + 1 / (c.roughness * c.roughness));
              EXPECT_NEAR(many.density, one.density, rounding * one.density + 1e-300)
                  << c.name << ' ' << to_text(wi) << ' ' << to_text(wo);
              EXPECT_EQ(many.schlick, one.schlick);
            }
          },
          c.medium);
    }
  }
}

TEST(PhaseFunction, OfLambertFlakesIntegratesToOne) {
  constexpr int kAzimuths = 8;
  for (const MediumCase& c : media_cases()) {
    if (!c.costly) continue;
    const Direction wi = incident_directions()[2];
    const Frame<double> frame = frame_around(c.axis);
    const auto ring = [&](double mu) {
      double sum = 0;
      for (int k = 0; k < kAzimuths; ++k) {
        const Direction wo = direction_from_mu_phi(mu, 2 * kPi * (k + 0.5) / kAzimuths);
        sum += phase(c.medium, wi, frame.to_world(wo)).density;
      }
      return 2 * kPi * sum / kAzimuths;
    };
    using boost::math::quadrature::gauss;
    const double sum =
        gauss<double, 7>::integrate(ring, -1.0, 0.0) + gauss<double, 7>::integrate(ring, 0.0, 1.0);
    // 112 points of a function whose second derivative jumps; measured: 2e-3.
    EXPECT_NEAR(sum, 1, 4e-3) << c.name;
  }
}

TEST(PhaseFunction, IsLocallyReciprocalForEveryMedium) {
  for (const MediumCase& c : media_cases()) {
    std::vector<Direction> directions = incident_directions();
    if (c.costly) directions.resize(4);
    for (const Direction wi : directions)
      for (const Direction wo : directions) expect_reciprocal(c.medium, wi, wo, 1e-8);
  }
}

RC_GTEST_PROP(PhaseFunction, SggxMirrorsAreReciprocalAtAnyMatrix, ()) {
  // L L^T of any lower triangular matrix with a positive diagonal
  const double a = any_number(0.05, 1), b = any_number(0.05, 1), c = any_number(0.05, 1);
  const double d = any_number(-1, 1), e = any_number(-1, 1), f = any_number(-1, 1);
  const Sggx ndf({a * a, d * d + b * b, e * e + f * f + c * c, a * d, a * e, d * e + b * f});
  const Direction wi = any_direction(), wo = any_direction();
  expect_reciprocal(MirrorFlakes<Sggx>{ndf}, wi, wo, 1e-10);
  RC_ASSERT(std::abs(ndf.sigma(wi) - ndf.sigma(-wi)) <= 1e-15 * ndf.sigma(wi));
}

RC_GTEST_PROP(PhaseFunction, VmfFlakesAreReciprocalAtAnyRoughness, ()) {
  const Vmf ndf(vmf_alpha(any_number(0, 1)), any_direction());
  const Direction wi = any_direction(), wo = any_direction();
  expect_reciprocal(MirrorFlakes<Vmf>{ndf}, wi, wo, 1e-6);
  expect_reciprocal(LambertFlakes<Vmf>{ndf}, wi, wo, 1e-6);
  // One-sided: the odd part is the mean normal.
  EXPECT_NEAR(ndf.sigma(wi) - ndf.sigma(-wi), dot(wi, ndf.mean_normal()), 1e-14);
}

RC_GTEST_PROP(PhaseFunction, HenyeyGreensteinIsReciprocalAndPositiveAtAnyG, ()) {
  const Medium medium = HenyeyGreenstein{any_number(-0.999, 0.999)};
  const Direction wi = any_direction(), wo = any_direction();
  expect_reciprocal(medium, wi, wo, 1e-12);
  RC_ASSERT(phase(medium, wi, wo).density > 0);
}

TEST(HalfVector, IsTheSumAndItsLimitInTheVerticalPlaneAtOppositeDirections) {
  const Direction wi = direction_from_mu_phi(0.6, 1.1);
  EXPECT_EQ(half_vector(wi, {0, 0, 1}), (wi + Direction{0, 0, 1}));
  const Direction h = half_vector(wi, -wi);
  EXPECT_NEAR(dot(h, wi), 0, 1e-15);
  EXPECT_NEAR(length(h), 1, 1e-15);
  EXPECT_GT(h.z, 0);
  EXPECT_NEAR(wi.x * h.y - wi.y * h.x, 0, 1e-15);
  // The limit of w_i + w_o as w_o comes up within that plane.
  const Direction near = normalized(-wi + 1e-6 * h);
  const Direction limit = normalized(half_vector(wi, near));
  EXPECT_NEAR(length(limit - h), 0, 1e-6);
  EXPECT_EQ(half_vector(-wi, wi), h);
  EXPECT_EQ(half_vector({0, 0, 1}, {0, 0, -1}), (Direction{1, 0, 0}));
}

TEST(HenyeyGreenstein, MeanDeflectionCosineIsG) {
  for (const double g : {-0.9, -0.3, 0.0, 1e-9, 0.5, 0.95}) {
    const Direction d{0, 0, 1};
    const double mean =
        integrate_sphere([&](Direction w) { return w.z * henyey_greenstein_phase(g, w.z); },
                         {.axis = g < 0 ? -d : d, .width = 1 - std::abs(g) + 0.05}, 1e-10);
    EXPECT_NEAR(mean, g, 1e-9);
  }
}

TEST(HenyeyGreenstein, InverseReturnsTheQuantileOfTheCumulativeDistribution) {
  for (const double g : {-0.99, -0.5, -1e-12, 0.0, 1e-12, 1e-3, 0.8, 0.999})
    for (const double u : {1e-10, 0.01, 0.5, 0.9, 1 - 1e-10}) {
      const double c = henyey_greenstein_cosine(g, u);
      ASSERT_LE(std::abs(c), 1 + 1e-15);
      // P(cos < c), the closed form rearranged so that g -> 0 is no special case:
      // (1 - g^2) / (2 g) (1 / r - 1 / (1 + g)), r^2 = 1 + g^2 - 2 g c
      const double r = std::sqrt((1 - g) * (1 - g) + 2 * g * (1 - c));
      const double cdf = (1 - g) * (1 + c) / (r * (1 + g + r));
      // Rounding, and that of the cosine times the density.
      const double slope = 2 * kPi * henyey_greenstein_phase(g, c);
      EXPECT_NEAR(cdf, u, 1e-12 + 4e-16 * slope) << g << ' ' << u;
    }
}

}  // namespace
}  // namespace lamella::testing
