#include "phase/grains/grain_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"
#include "phase/stack/stack_file.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

Stack parse_grains(const std::string& text) { return parse_stack(text, "file.toml", "name"); }

std::string grain_error_of(const std::string& text) {
  try {
    (void)parse_grains(text);
  } catch (const StackFileError& error) {
    return error.what();
  }
  return "no error";
}

const std::string kBed =
    "[[layer]]\nmedium = 'sphere_bed'\nradius = 0.02\npacking = 0.05\nthickness = 4\n";
const std::string kMicrograins =
    "[[layer]]\nmedium = 'micrograins'\ntau0 = 0.5\nbeta = 0.25\nradius = 2\n";

GrainGeometry bed(GrainPlacement placement, double packing) {
  return {.placement = placement, .radius = 0.1, .packing = packing, .thickness = 1, .tile = 1};
}

TEST(GrainGeometry, IsReadWithItsDefaultsAndSurvivesTheRoundTrip) {
  for (const std::string& text : std::initializer_list<std::string>{
           kBed + "albedo = 0.9\nsurface = 'mirror'\n", kBed + "[substrate]\nalbedo = 0.5",
           "[[layer]]\nmedium = 'packed_sphere_bed'\nradius = 1\npacking = 0.3\nthickness = 9\n",
           kMicrograins + "surface = 'dielectric'\n[substrate]\nalbedo = [0.1, 0.2, 0.3]",
           kMicrograins + "surface = 'conductor'\nf0 = [0.9, 0.6, 0.5]"}) {
    const Stack stack = parse_grains(text);
    ASSERT_TRUE(stack.grains());
    const Stack again = parse_grains(to_toml(stack));
    EXPECT_EQ(to_toml(again), to_toml(stack));
    EXPECT_EQ(again.grains()->tile, stack.grains()->tile);
    EXPECT_FALSE(stack.is_half_space());
  }
  const Stack stack = parse_grains(kBed);
  EXPECT_EQ(stack.grains()->surface, GrainSurface::lambert);
  EXPECT_NEAR(stack.grains()->expected_count(), 20000, 1e-6);
  EXPECT_TRUE(stack.is_open_below());
  EXPECT_FALSE(parse_grains(kMicrograins).is_open_below()) << "micrograins stand on a black plane";
  EXPECT_EQ(parse_grains(kMicrograins).grains()->top(), 0.5);
  EXPECT_THROW((void)stack.uncollided({0, 0, 1}), std::invalid_argument);
}

TEST(GrainGeometry, MisuseIsNamedWithItsLineKeyAndWhatIsAllowed) {
  const std::string slab = "[[layer]]\nmedium = 'sggx'\nroughness = 1\nthickness = 1\n";
  EXPECT_EQ(grain_error_of(kBed + slab),
            "file.toml:2: layer 0: key \"medium\": found \"sphere_bed\" among 2 layers; allowed: "
            "explicit geometry as the only layer, over a [substrate] or none");
  EXPECT_NE(grain_error_of(slab + kBed).find("file.toml:6: layer 1: key \"medium\""),
            std::string::npos);
  const auto expect = [](const std::string& text, const std::string& part) {
    EXPECT_NE(grain_error_of(text).find(part), std::string::npos) << grain_error_of(text);
  };
  expect(kBed + "density = 2\n", "file.toml:6: key \"density\": unknown in layer 0");
  expect(kBed + "f0 = 0.5\n", "file.toml:6: layer 0: key \"f0\": found 0.5; allowed: nothing");
  expect(kBed + "surface = 'conductor'\n", "key \"surface\": found \"conductor\"; allowed");
  expect(kBed + "tile = 0.07\n", "key \"tile\": found 0.07; allowed: a number in [0.08, inf)");
  expect(kBed + "tile = 1000\n", "key \"tile\": found 1000");
  expect("[[layer]]\nmedium = 'sphere_bed'\nradius = 1\npacking = 1\nthickness = inf\n",
         "file.toml:5: layer 0: key \"thickness\": found inf; allowed");
  expect("[[layer]]\nmedium = 'sphere_bed'\nradius = 1\nthickness = 1\n",
         "key \"packing\": found nothing; allowed");
  expect("[[layer]]\nmedium = 'packed_sphere_bed'\nradius = 1\npacking = 0.4\nthickness = 1\n",
         "key \"packing\": found 0.4; allowed: a number in (0, 0.384)");
  expect(kMicrograins + "ior = 1.4\n", "key \"ior\": found 1.4; allowed: nothing");
  expect(kMicrograins + "thickness = 1\n", "key \"thickness\": unknown in layer 0");
  expect("[[layer]]\nmedium = 'micrograins'\nbeta = 1\n", "key \"tau0\": found nothing");
  expect("[[layer]]\nmedium = 'micrograins'\nbeta = 1\ntau0 = 1\n", "key \"tau0\": found 1;");
  expect("[[layer]]\nmedium = 'sphere_bd'\n", "did you mean \"sphere_bed\"?");
}

TEST(GrainGeometry, APoissonBedHasPoissonsCountsAndUniformCentres) {
  const GrainGeometry g = bed(GrainPlacement::sphere_bed, 0.4);
  std::vector<double> counts, x, y, z;
  for (int k = 0; k < 400; ++k) {
    const auto centres = place_grains(g, 7, k);
    counts.push_back(static_cast<double>(centres.size()));
    for (const Direction& p : centres) {
      ASSERT_TRUE(p.x >= 0 && p.x < g.tile && p.y >= 0 && p.y < g.tile);
      ASSERT_TRUE(p.z <= 0 && p.z >= -g.thickness);
      x.push_back(p.x);
      y.push_back(p.y);
      z.push_back(-p.z);
    }
  }
  const double expected = g.expected_count();
  EXPECT_NEAR(expected, 0.4 / (4 * kPi / 3 * 1e-3), 1e-9);
  EXPECT_GT(mean_p_value(counts, expected), test_level());
  std::vector<double> squares;
  for (const double n : counts) squares.push_back((n - expected) * (n - expected));
  EXPECT_GT(mean_p_value(squares, expected), test_level()) << "variance of a Poisson number";
  for (const auto& axis : {x, y, z}) EXPECT_GT(mean_p_value(axis, 0.5), test_level());
}

TEST(GrainGeometry, APackedBedReachesItsPackingWithoutOverlap) {
  const GrainGeometry g = bed(GrainPlacement::packed_sphere_bed, 0.33);
  const auto centres = place_grains(g, 3, 1);
  EXPECT_NEAR(static_cast<double>(centres.size()), g.expected_count(), 1);
  double nearest = 1e9;
  for (std::size_t i = 0; i < centres.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      Direction d = centres[i] - centres[j];
      d.x -= std::round(d.x);
      d.y -= std::round(d.y);
      nearest = std::min(nearest, length(d));
    }
  EXPECT_GE(nearest, 2 * g.radius);
}

TEST(GrainGeometry, APackingOutOfReachIsReported) {
  // A thin slab packs more loosely per volume of centres only if it is thick: here it does not.
  GrainGeometry g = bed(GrainPlacement::packed_sphere_bed, 0.383);
  g.thickness = 1.5;
  try {
    (void)place_grains(g, 1, 0);
    // Walls make room: centres at the boundary exclude less. Then the packing must have held.
    EXPECT_NEAR(static_cast<double>(place_grains(g, 1, 0).size()), g.expected_count(), 1);
    g.packing = 0.6;
    (void)place_grains(g, 1, 0);
    FAIL();
  } catch (const PackingError& error) {
    EXPECT_NE(std::string(error.what()).find("is out of reach"), std::string::npos);
  }
}

TEST(GrainGeometry, RealisationsAreReproducibleAndDiffer) {
  for (const GrainPlacement placement :
       {GrainPlacement::sphere_bed, GrainPlacement::packed_sphere_bed,
        GrainPlacement::micrograins}) {
    GrainGeometry g = bed(placement, 0.2);
    g.tau0 = 0.5;
    EXPECT_EQ(place_grains(g, 5, 2), place_grains(g, 5, 2));
    EXPECT_NE(place_grains(g, 5, 2), place_grains(g, 5, 3));
    EXPECT_NE(place_grains(g, 5, 2), place_grains(g, 6, 2));
  }
}

}  // namespace
}  // namespace lamella::testing
