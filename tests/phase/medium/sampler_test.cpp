#include <gtest/gtest.h>

#include "tests/phase/medium/media_cases.h"

namespace lamella::testing {
namespace {

class EveryMedium : public ::testing::TestWithParam<MediumCase> {};

TEST_P(EveryMedium, SamplesFollowThePhaseFunction) {
  const MediumCase& c = GetParam();
  for (const Direction wi : incident_directions()) {
    if (!scatters(c, wi)) continue;
    const auto sample = [&](RandomStream& stream) {
      return std::visit([&](const auto& m) { return m.collide(wi, stream).sample(stream).wo; },
                        c.medium);
    };
    const auto density = [&](Direction wo) { return phase(c.medium, wi, wo).density; };
    EXPECT_GE(sampler_p_value(c.name + " from " + to_text(wi), lobe_cells(c, wi), sample, density,
                              c.costly ? 40000 : 100000),
              test_level())
        << to_text(wi);
  }
}

TEST_P(EveryMedium, EventsAverageToThePhaseFunction) {
  const MediumCase& c = GetParam();
  std::uint64_t seed = 0;
  for (const Direction wi : incident_directions())
    for (const double mu : {0.4, -0.7}) {
      const Direction wo = direction_from_mu_phi(mu, 0.8 * ++seed);
      const double expected = phase(c.medium, wi, wo).density;
      // The normal limit needs more than a few rare events.
      if (!scatters(c, wi) || expected < 0.02) continue;
      RandomStream stream(seed, 0, StreamPurpose::test);
      std::vector<double> values(10000);
      for (double& v : values)
        v = std::visit([&](const auto& m) { return m.collide(wi, stream).density(wo).density; },
                       c.medium);
      EXPECT_GE(mean_p_value(values, expected), test_level()) << to_text(wi) << ' ' << to_text(wo);
    }
}

TEST_P(EveryMedium, SampledSchlickWeightIsThatOfThePair) {
  const MediumCase& c = GetParam();
  RandomStream stream(5, 0, StreamPurpose::test);
  for (const Direction wi : incident_directions()) {
    if (!scatters(c, wi)) continue;
    for (int n = 0; n < 100; ++n) {
      const Scatter s =
          std::visit([&](const auto& m) { return m.collide(wi, stream).sample(stream); }, c.medium);
      // The half angle loses half of the digits where w_o nears -w_i.
      EXPECT_NEAR(s.schlick, phase(c.medium, wi, s.wo).schlick, 1e-6);
      EXPECT_NEAR(length(s.wo), 1, 1e-14);
    }
  }
}

std::string test_name(const ::testing::TestParamInfo<MediumCase>& instance) {
  std::string name;
  for (const char ch : instance.param.name)
    name += std::isalnum(static_cast<unsigned char>(ch)) ? ch : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Media, EveryMedium, ::testing::ValuesIn(media_cases()), test_name);

}  // namespace
}  // namespace lamella::testing
