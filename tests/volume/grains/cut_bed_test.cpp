#include <gtest/gtest.h>

#include <cmath>

#include "tests/statistics/statistics.h"
#include "tests/volume/run/stacks.h"
#include "volume/grains/grain_measure.h"

namespace lamella::testing {
namespace {

GrainGeometry packed(double packing, bool cut, double thickness = 12) {
  GrainGeometry g{.placement = GrainPlacement::packed_sphere_bed,
                  .radius = 1,
                  .packing = packing,
                  .thickness = thickness,
                  .tile = 30};
  g.cut = cut;
  return g;
}

TEST(CutBed, FillsWhatIsAskedForAtEveryDepth) {
  for (const double packing : {0.1, 0.34}) {
    const GrainMeasurement m = measure_grains(packed(packing, true), 1, 32, 2000);
    EXPECT_LT(std::abs(m.filled.value - packing), allowed_z() * m.filled.standard_error);
    EXPECT_LT(m.filled.standard_error, 0.01);
    ASSERT_EQ(m.profile.size(), 20u);
    for (const ProfileSlice& s : m.profile) {
      // Centres begin at z = 0; spheres reach one radius higher.
      const double right = s.z_to >= 0 ? 0 : packing;
      EXPECT_LT(std::abs(s.packing.value - right), allowed_z() * s.packing.standard_error + 1e-12)
          << s.z_from;
      if (s.z_from <= -1) {
        EXPECT_LT(std::abs(s.filled.value - packing), allowed_z() * s.filled.standard_error)
            << s.z_from;
      }
    }
  }
}

TEST(CutBed, SpheresDoNotOverlapAndKeepToTheirHeights) {
  for (const double thickness : {0.1, 3.0, 12.0}) {
    const GrainGeometry g = packed(0.3, true, thickness);
    const auto centres = place_grains(g, 5, 2);
    double mean = 0;
    for (std::size_t k = 0; k < 32; ++k)
      mean += static_cast<double>(place_grains(g, 6, k).size()) / 32;
    // Numbers of a cut fluctuate less than Poisson's.
    EXPECT_NEAR(mean, g.expected_count(), 4 * std::sqrt(g.expected_count() / 32) + 0.5);
    for (std::size_t a = 0; a < centres.size(); ++a) {
      EXPECT_LE(centres[a].z, 0);
      EXPECT_GE(centres[a].z, -thickness);
      for (std::size_t b = 0; b < a; ++b) {
        Direction d = centres[a] - centres[b];
        d.x -= g.tile * std::round(d.x / g.tile);
        d.y -= g.tile * std::round(d.y / g.tile);
        ASSERT_GE(dot(d, d), 4) << a << ' ' << b;
      }
    }
  }
}

TEST(CutBed, WithoutItCentresCrowdAtTheSurface) {
  const GrainMeasurement m = measure_grains(packed(0.3, false), 1, 32, 2000);
  const Estimate& first = m.profile[2].packing;  // the half radius below the topmost centres
  EXPECT_GT(first.value - allowed_z() * first.standard_error, 1.2 * 0.3);
  EXPECT_LT(m.filled.value + allowed_z() * m.filled.standard_error, 0.3);
}

TEST(CutBed, TheKeyIsReadFromFiles) {
  const char* text =
      "medium = 'packed_sphere_bed'\nradius = 0.02\npacking = 0.3\nthickness = 0.2\ntile = 0.3\n";
  EXPECT_FALSE(stack_from(layer(text)).grains()->cut);
  EXPECT_FALSE(stack_from(layer(std::string(text) + "cut = false")).grains()->cut);
  const Stack cut = stack_from(layer(std::string(text) + "cut = true"));
  EXPECT_TRUE(cut.grains()->cut);
  EXPECT_TRUE(parse_stack(to_toml(cut), "again", "again").grains()->cut);
  try {
    (void)stack_from(layer(std::string(text) + "cut = 1"));
    FAIL();
  } catch (const std::exception& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("key \"cut\": found 1; allowed: "), std::string::npos) << what;
  }
}

}  // namespace
}  // namespace lamella::testing
