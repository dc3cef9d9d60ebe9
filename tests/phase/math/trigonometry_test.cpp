#include "phase/math/trigonometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "phase/medium/henyey_greenstein.h"
#include "phase/medium/lambert_sphere.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

TEST(Trigonometry, SineAndCosineOfTurnsAreWithinTheirBound) {
  constexpr long double kTwoPi = 6.283185307179586476925286766559L;
  for (int k = 0; k <= 400000; ++k) {
    const double u = k / 400000.0;
    const auto [sine, cosine] = sine_cosine_of_turns(u);
    EXPECT_LT(std::abs(sine - sinl(kTwoPi * u)), 2e-15L) << u;
    EXPECT_LT(std::abs(cosine - cosl(kTwoPi * u)), 2e-15L) << u;
  }
}

TEST(Trigonometry, NearZeroSineAndCosineAreWithinTheirBound) {
  for (int k = -200000; k <= 200000; ++k) {
    const double x = k * (kPi / 4) / 200000;
    const auto [sine, cosine] = sine_cosine_near_zero(x);
    EXPECT_LT(std::abs(sine - sinl(static_cast<long double>(x))), 1.5e-16L) << x;
    EXPECT_LT(std::abs(cosine - cosl(static_cast<long double>(x))), 1.5e-16L) << x;
  }
}

TEST(Trigonometry, ManyDeflectionsKeepADirectionUnit) {
  RandomStream stream(3, 0, StreamPurpose::test);
  Direction w = direction_from_mu_phi(0.3, 1);
  double worst = 0;
  for (int k = 0; k < 100000; ++k) {
    w = deflect(w, 2 * stream.uniform() - 1, stream.uniform());
    worst = std::max(worst, std::abs(dot(w, w) - 1));
  }
  EXPECT_LT(worst, 1e-14);
}

template <class Medium>
void expect_sampler_matches(const Medium& medium, const std::string& name) {
  for (const double mu : {1.0, 0.6, 0.02, -0.5, -1.0}) {
    const Direction wi = direction_from_mu_phi(mu, 0.7);
    const auto sample = [&](RandomStream& stream) {
      return medium.collide(wi, stream).sample(stream).wo;
    };
    const auto density = [&](Direction wo) { return medium.phase(wi, wo).density; };
    EXPECT_GT(testing::sampler_p_value(name, wi, sample, density), testing::test_level()) << mu;
  }
}

TEST(Trigonometry, ParticlesAreSampledByTheirPhaseFunction) {
  expect_sampler_matches(LambertSphere{}, "lambert_sphere");
  expect_sampler_matches(HenyeyGreenstein{0.7}, "henyey_greenstein");
}

}  // namespace
}  // namespace lamella
