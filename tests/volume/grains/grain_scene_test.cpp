#include "volume/grains/grain_scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include "phase/math/direction.h"
#include "phase/math/sampling.h"
#include "phase/random/random.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

GrainGeometry bed_of(double packing) {
  return {.placement = GrainPlacement::sphere_bed,
          .radius = 0.25,
          .packing = packing,
          .thickness = 2,
          .tile = 3};
}

GrainGeometry micrograins(double tau0, double beta) {
  return {.placement = GrainPlacement::micrograins,
          .radius = 0.25,
          .thickness = 0.25 * beta,
          .tau0 = tau0,
          .beta = beta,
          .tile = 3};
}

/// The nearest grain by trying every one in every period, in double precision.
double distance_by_trying_all(const GrainGeometry& g, const std::vector<Direction>& centres,
                              Direction o, Direction d) {
  double nearest = std::numeric_limits<double>::infinity();
  const Direction d1{d.x, d.y, d.z / g.beta};
  for (const Direction& c : centres)
    for (int i = -12; i <= 12; ++i)
      for (int j = -12; j <= 12; ++j) {
        const Direction m{o.x - c.x - i * g.tile, o.y - c.y - j * g.tile, (o.z - c.z) / g.beta};
        const double a = dot(d1, d1), b = dot(m, d1), c0 = dot(m, m) - g.radius * g.radius;
        const double disc = b * b - a * c0;
        if (b < 0 && disc > 0) nearest = std::min(nearest, (-b - std::sqrt(disc)) / a);
      }
  return nearest;
}

TEST(GrainScene, MeetsWhatTryingEveryGrainOfEveryPeriodMeets) {
  int grains = 0;
  for (const GrainGeometry& g : {bed_of(0.15), micrograins(0.3, 0.4)}) {
    const auto centres = place_grains(g, 4, 0);
    const GrainScene scene(g, centres);
    RandomStream stream(2, 0, StreamPurpose::test);
    for (int k = 0; k < 300; ++k) {
      const Direction o{g.tile * stream.uniform(), g.tile * stream.uniform(), g.top()};
      Direction d = cosine_hemisphere(Direction{0, 0, -1}, stream.uniform(), stream.uniform());
      if (d.z > -0.1) continue;  // within the periods that are tried
      const GrainHit hit = scene.trace(o, d);
      const double expected = distance_by_trying_all(g, centres, o, d);
      const double floor = (g.bottom() - o.z) / d.z;
      if (expected < floor) {
        ++grains;
        ASSERT_EQ(hit.end, RayEnd::grain) << k;
        EXPECT_NEAR(hit.point.z, o.z + expected * d.z, 1e-12);
        EXPECT_LT(dot(d, hit.normal), 0);
        EXPECT_NEAR(length(hit.normal), 1, 1e-14);
        EXPECT_FALSE(scene.is_free(o, d));
      } else {
        EXPECT_EQ(hit.end, RayEnd::down) << k;
        EXPECT_TRUE(scene.is_free(o, d));
      }
    }
    EXPECT_EQ(scene.holes(), 0U);
  }
  EXPECT_GT(grains, 200);
}

TEST(GrainScene, NothingThatLeavesAGrainMeetsItAgainAndNoRayGetsIn) {
  // Dense and overlapping: many hits near the edges between grains.
  for (const GrainGeometry& g : {bed_of(3), micrograins(0.95, 0.1), micrograins(0.95, 1)}) {
    const GrainScene scene(g, place_grains(g, 1, 0));
    RandomStream stream(3, 0, StreamPurpose::test);
    int inside = 0, hits = 0;
    for (int k = 0; k < 3000; ++k) {
      Direction p{g.tile * stream.uniform(), g.tile * stream.uniform(), g.top()};
      Direction d = cosine_hemisphere(Direction{0, 0, -1}, stream.uniform(), stream.uniform());
      for (int bounce = 0; bounce < 10; ++bounce) {
        const GrainHit hit = scene.trace(p, d);
        if (hit.end == RayEnd::up || hit.end == RayEnd::lost) break;
        if (hit.end == RayEnd::grain) {
          ++hits;
          inside += scene.is_inside(hit.point);
          // The same grain at no distance would show as a hit that does not move.
          EXPECT_GT(length(hit.point - p), 0);
        }
        p = hit.point;
        d = cosine_hemisphere(hit.normal, stream.uniform(), stream.uniform());
      }
    }
    EXPECT_GT(hits, 2000);
    EXPECT_EQ(inside, 0);
    EXPECT_EQ(scene.holes(), 0U);
  }
}

TEST(GrainScene, FillsTheShareOfSpaceThatPoissonSpheresFill) {
  const GrainGeometry g = bed_of(0.7);
  std::vector<double> shares;
  for (int k = 0; k < 200; ++k) {
    const GrainScene scene(g, place_grains(g, 9, k));
    RandomStream stream(5, k, StreamPurpose::test);
    int inside = 0;
    for (int j = 0; j < 200; ++j)
      inside += scene.is_inside({g.tile * stream.uniform(), g.tile * stream.uniform(),
                                 -g.radius - (g.thickness - 2 * g.radius) * stream.uniform()});
    shares.push_back(inside / 200.0);
  }
  EXPECT_GT(mean_p_value(shares, 1 - std::exp(-g.packing)), test_level());
}

TEST(GrainScene, SeesTheFillingFactorOfTheMicrograinPaper) {
  // Lucas et al. 2023, eq. 22: 1 - sqrt((1 - tau)(1 - tau0)), tau of eq. 21.
  for (const double tau0 : {0.2, 0.8})
    for (const double theta : {0.0, 45.0, 75.0}) {
      const GrainGeometry g = micrograins(tau0, 0.5);
      std::vector<double> shares;
      const Direction d = -direction_from_degrees(theta, 0);
      for (int k = 0; k < 200; ++k) {
        const GrainScene scene(g, place_grains(g, 11, k));
        RandomStream stream(6, k, StreamPurpose::test);
        const double turn = 2 * kPi * stream.uniform();
        const Direction turned{d.x * std::cos(turn), d.x * std::sin(turn), d.z};
        int grains = 0;
        for (int j = 0; j < 100; ++j)
          grains +=
              scene.trace({g.tile * stream.uniform(), g.tile * stream.uniform(), g.top()}, turned)
                  .end == RayEnd::grain;
        shares.push_back(grains / 100.0);
      }
      const double mu = -d.z, t2 = (1 - mu * mu) / (mu * mu);
      const double tau = 1 - std::pow(1 - tau0, std::sqrt(1 + g.beta * g.beta * t2));
      const double expected = 1 - std::sqrt((1 - tau) * (1 - tau0));
      EXPECT_GT(mean_p_value(shares, expected), test_level()) << tau0 << " " << theta;
    }
}

}  // namespace
}  // namespace lamella::testing
