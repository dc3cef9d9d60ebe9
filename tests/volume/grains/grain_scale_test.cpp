#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "phase/math/direction.h"
#include "tests/volume/run/stacks.h"
#include "volume/grains/grain_measure.h"
#include "volume/grains/grain_scene.h"

namespace lamella::testing {
namespace {

/// Grains of radius `radius` mm, all lengths in proportion.
Stack grains(const char* medium, double radius) {
  const std::string shape = std::string(medium) == "micrograins"
                                ? "tau0 = 0.6\nbeta = 0.5\n"
                                : fmt::format("packing = 0.25\nthickness = {:.17g}\n", 8 * radius);
  return stack_from(layer(fmt::format("medium = '{}'\nradius = {:.17g}\ntile = {:.17g}\n{}", medium,
                                      radius, 12 * radius, shape)));
}

RunResult simulate(const Stack& stack, Estimator estimator) {
  Simulation simulation(stack, make_plan(stack), direction_from_degrees(40, 0), estimator,
                        CellGrid{4, 8, false}, 3);
  simulation.advance(512);
  return reduce(simulation);
}

constexpr const char* kMedia[] = {"sphere_bed", "packed_sphere_bed", "micrograins"};

TEST(GrainScale, LobesAreTheSameBitByBitAtRadiiThatDifferByPowersOfTwo) {
  for (const char* medium : kMedia)
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const RunResult right = simulate(grains(medium, 1.25), estimator);
      EXPECT_GT(right.reflected.total[0].value, 0.1) << medium;
      // 1e-45 to 1e30 and, so that no square or cube of a length is a number, far beyond.
      for (const int power : {-900, -149, -130, -7, 0, 6, 51, 100, 900}) {
        const RunResult found = simulate(grains(medium, std::ldexp(1.25, power)), estimator);
        SCOPED_TRACE(fmt::format("{} 2^{}", medium, power));
        EXPECT_EQ(found.reflected.total[0].value, right.reflected.total[0].value);
        EXPECT_EQ(found.uncollided[0].value, right.uncollided[0].value);
        EXPECT_EQ(found.holes, 0U);
        for (int o = 0; o <= kTallyOrders; ++o)
          EXPECT_EQ(found.reflected.lobes[o].value, right.reflected.lobes[o].value) << o;
      }
    }
}

TEST(GrainScale, LobesAreTheSameWithinTheirNoiseAtAnyRadius) {
  for (const char* medium : kMedia) {
    const RunResult right = simulate(grains(medium, 1), Estimator::analog);
    for (const double radius : {1e-45, 1e-40, 1e-3, 1e15, 3e15, 1e30}) {
      const RunResult found = simulate(grains(medium, radius), Estimator::analog);
      // The same placements up to rounding: paths differ once rounding has decided a hit.
      const Estimate &a = found.reflected.total[0], &b = right.reflected.total[0];
      EXPECT_LT(std::abs(a.value - b.value),
                allowed_z() * std::hypot(a.standard_error, b.standard_error))
          << medium << ' ' << radius;
    }
  }
}

TEST(GrainScale, PointsScaleWithTheRadius) {
  const GrainGeometry one = *grains("sphere_bed", 1).grains();
  const auto centres = place_grains(one, 1, 0);
  const GrainScene scene(one, centres);
  for (const double scale : {0x1p-150, 0x1p-20, 0x1p60, 0x1p100}) {
    GrainGeometry g = one;
    g.radius *= scale;
    g.tile *= scale;
    g.thickness *= scale;
    const auto scaled = place_grains(g, 1, 0);
    ASSERT_EQ(scaled.size(), centres.size());
    const GrainScene other(g, scaled);
    for (int k = 0; k < 200; ++k) {
      const Direction o{one.tile * (k % 14) / 14.0, one.tile * (k / 14) / 15.0, one.top()};
      const Direction d = -direction_from_degrees(k % 80, 17.0 * k);
      const GrainHit a = scene.trace(o, d), b = other.trace(scale * o, d);
      EXPECT_EQ(a.end, b.end);
      if (a.end == RayEnd::up || a.end == RayEnd::lost) continue;
      EXPECT_EQ(scale * a.point, b.point);
      EXPECT_EQ(a.normal, b.normal);
      EXPECT_EQ(scene.is_inside(o), other.is_inside(scale * o));
    }
  }
}

TEST(GrainScale, MeasuresScaleWithTheRadius) {
  const GrainMeasurement right = measure_grains(*grains("sphere_bed", 1).grains(), 1, 8, 500);
  for (const double scale : {0x1p-140, 0x1p90}) {
    const GrainMeasurement found = measure_grains(*grains("sphere_bed", scale).grains(), 1, 8, 500);
    EXPECT_EQ(found.filled.value, right.filled.value);
    EXPECT_EQ(found.extinction.value * scale, right.extinction.value);
    EXPECT_EQ(found.surface_area.standard_error * scale, right.surface_area.standard_error);
    EXPECT_EQ(found.profile[3].packing.value, right.profile[3].packing.value);
    EXPECT_EQ(found.profile[3].z_to, right.profile[3].z_to * scale);
  }
}

}  // namespace
}  // namespace lamella::testing
