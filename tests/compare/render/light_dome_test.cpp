#include "compare/render/light_dome.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

Direction sampled(const LightDome& dome, RandomStream& stream) {
  const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
  return dome.sample(u1, u2, u3)->w;
}

}  // namespace

TEST(LightDome, SamplesHaveTheirDensity) {
  const Direction lamp = direction_from_degrees(40, 30);
  for (const SkyKind sky : {SkyKind::uniform, SkyKind::clear, SkyKind::overcast}) {
    const LightDome dome(sky, std::nullopt);
    EXPECT_GT(sampler_p_value(
                  "sky", Direction{0, 1, 0}, [&](RandomStream& s) { return sampled(dome, s); },
                  [&](Direction w) { return dome.density(w); }, 50000),
              test_level());
    // With a lamp, of which the density is a step: the share of its samples.
    const LightDome lit(sky, lamp);
    constexpr int kSamples = 20000;
    int inside = 0;
    for (int n = 0; n < kSamples; ++n) {
      RandomStream stream(1, static_cast<std::uint64_t>(n), StreamPurpose::test);
      const Direction w = sampled(lit, stream);
      inside += dot(w, lamp) > std::cos(LightDome::kLampRadius);
      EXPECT_GT(lit.density(w), 0);
    }
    const double area = 2 * kPi * (1 - std::cos(LightDome::kLampRadius));
    const double share = area * lit.density(lamp);
    EXPECT_NEAR(inside / static_cast<double>(kSamples), share,
                normal_quantile(test_level()) * std::sqrt(share * (1 - share) / kSamples));
  }
}

TEST(LightDome, SkiesAndTheLampGiveTheIrradiancePi) {
  // By the mean over samples of radiance cos / density, whose error is measured.
  const auto irradiance = [](const LightDome& dome, Direction n) {
    constexpr int kSamples = 40000;
    double sum = 0, square = 0;
    for (int k = 0; k < kSamples; ++k) {
      RandomStream stream(2, static_cast<std::uint64_t>(k), StreamPurpose::test);
      const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
      const auto s = dome.sample(u1, u2, u3);
      const double x = std::max(0.0, dot(s->w, n)) * s->radiance.g / s->density;
      sum += x;
      square += x * x;
    }
    const double mean = sum / kSamples;
    return std::pair(mean, std::sqrt((square / kSamples - mean * mean) / kSamples));
  };
  const double allowed = normal_quantile(test_level());
  const Direction lamp = direction_from_degrees(30, 80);
  for (const SkyKind sky : {SkyKind::uniform, SkyKind::clear, SkyKind::overcast}) {
    const auto [alone, error] = irradiance(LightDome(sky, std::nullopt), {0, 1, 0});
    EXPECT_NEAR(alone, kPi, allowed * error + 1e-3);
    const auto [both, both_error] = irradiance(LightDome(sky, lamp), {0, 1, 0});
    // The clear sky is another about another sun, but of the same irradiance.
    EXPECT_NEAR(both, kPi + kPi * lamp.y, allowed * both_error + 2e-3);
  }
}

}  // namespace lamella::testing
