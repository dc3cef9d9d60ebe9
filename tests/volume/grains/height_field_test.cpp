// Height fields: slopes against Beckmann's, rays against all triangles one by one, energies, and
// the light that a surface sends out against Smith's surface of the same slopes.
#include "volume/grains/height_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "phase/math/direction.h"
#include "phase/random/random.h"
#include "phase/stack/stack_file.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

GrainGeometry field_of(double alpha, int nodes = 256, double tile = 32) {
  return {.placement = GrainPlacement::height_field,
          .radius = 1,
          .thickness = 8 * alpha,
          .tile = tile,
          .alpha = alpha,
          .nodes = nodes};
}

TEST(HeightField, HasBeckmannsSlopes) {
  for (const double alpha : {0.05, 0.5}) {
    double square[2]{}, product = 0, fourth = 0, heights = 0, covariance = 0;
    int count = 0;
    for (std::uint64_t realisation = 0; realisation < 24; ++realisation) {
      const HeightField field(field_of(alpha), 1, realisation);
      for (int j = 0; j < field.nodes(); ++j)
        for (int i = 0; i < field.nodes(); ++i, ++count) {
          const double h = field.height(i, j);
          const double gx = (field.height(i + 1, j) - h) / field.step(),
                       gy = (field.height(i, j + 1) - h) / field.step();
          square[0] += gx * gx;
          square[1] += gy * gy;
          product += gx * gy;
          fourth += gx * gx * gx * gx;
          heights += h * h;
          covariance += h * field.height(i + 8, j);  // a correlation length away
        }
    }
    const double variance = alpha * alpha / 2;
    // 32 x 32 correlation areas, in each of which a slope is worth about two numbers.
    const double error = std::sqrt(2.0 / (24 * 32 * 32 * 2));
    EXPECT_NEAR(square[0] / count, variance, 5 * error * variance);
    EXPECT_NEAR(square[1] / count, variance, 5 * error * variance);
    EXPECT_NEAR(product / count, 0, 5 * error * variance);
    EXPECT_NEAR(fourth / count / (3 * variance * variance), 1, 12 * error);
    // alpha = 2 h / length, less what the triangles' sides round off: (step / length)^2 / 2.
    EXPECT_NEAR(heights / count, alpha * alpha / 4 * (1 + 1 / 128.0),
                8 * error * alpha * alpha / 4);
    EXPECT_NEAR(covariance / heights, std::exp(-1), 8 * error);
  }
}

// The nearest triangle of the tile and its neighbours, found without any order.
GrainHit nearest(const HeightField& field, double tile, Direction o, Direction d) {
  GrainHit best;
  double nearest = std::numeric_limits<double>::infinity();
  const double step = field.step();
  const int n = field.nodes(), around = 3;
  for (int j = -around * n; j < (around + 1) * n; ++j)
    for (int i = -around * n; i < (around + 1) * n; ++i)
      for (const bool lower : {true, false}) {
        const auto node = [&](int di, int dj) {
          return Direction{(i + di) * step, (j + dj) * step, field.height(i + di, j + dj)};
        };
        const Direction a = lower ? node(0, 0) : node(1, 1), b = lower ? node(1, 0) : node(0, 1),
                        c = lower ? node(0, 1) : node(1, 0);
        const Direction normal = normalized(cross(b - a, c - a));
        const double along = dot(normal, d);
        if (along >= 0) continue;
        const double t = dot(normal, a - o) / along;
        if (t < 1e-9 || t >= nearest) continue;
        const Direction p = o + t * d;
        const auto inside = [&](Direction from, Direction to) {
          return dot(cross(to - from, p - from), normal) >= -1e-12;
        };
        if (!inside(a, b) || !inside(b, c) || !inside(c, a)) continue;
        nearest = t;
        best = {.end = RayEnd::grain,
                .point = {p.x - tile * std::floor(p.x / tile), p.y - tile * std::floor(p.y / tile),
                          p.z},
                .normal = normal};
      }
  return best;
}

TEST(HeightField, RaysMeetTheNearestTriangle) {
  const double tile = 8;
  const HeightField field(field_of(1, 24, tile), 5, 0);
  RandomStream stream(9, 0, StreamPurpose::test);
  int hits = 0, free = 0;
  for (int k = 0; k < 300; ++k) {
    Direction o{tile * stream.uniform(), tile * stream.uniform(), 4};
    Direction d = direction_from_mu_phi(-0.3 - 0.7 * stream.uniform(), 2 * kPi * stream.uniform());
    for (int bounce = 0; bounce < 3; ++bounce) {
      const GrainHit expected = nearest(field, tile, o, d), found = field.trace(o, d);
      ASSERT_EQ(found.end, expected.end) << k << ' ' << bounce;
      ASSERT_EQ(field.is_free(o, d), found.end == RayEnd::up);
      if (found.end == RayEnd::up) {
        ++free;
        break;
      }
      ++hits;
      EXPECT_NEAR(found.point.z, expected.point.z, 1e-9) << k;
      EXPECT_NEAR(dot(found.normal, expected.normal), 1, 1e-12) << k;
      EXPECT_LT(dot(found.normal, d), 0);
      o = found.point;
      d = d + (-2 * dot(d, found.normal)) * found.normal;
      if (std::abs(d.z) < 0.3) break;  // beyond the tiles of the search
    }
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(free, 50);
}

TEST(HeightField, NothingPassesOrStaysAnywhere) {
  for (const double alpha : {0.001, 0.3, 4.0}) {
    const Stack stack =
        parse_stack("[[layer]]\nmedium = 'height_field'\nsurface = 'mirror'\nroughness = " +
                        std::to_string(alpha) + "\n",
                    "test", "test");
    for (const double theta : {0.0, 89.9}) {
      Simulation simulation(stack, make_plan(stack, {.max_order = 100000}),
                            direction_from_degrees(theta, 0), Estimator::analog, CellGrid{2, 4}, 3);
      simulation.advance(1500);
      const RunResult run = reduce(simulation);
      EXPECT_NEAR(run.reflected.total[0].value, 1, 1e-12) << alpha << ' ' << theta;
      EXPECT_EQ(run.unresolved[0].value, 0) << alpha << ' ' << theta;
    }
  }
}

// A surface so flat that light meets it once is Smith's: order 1 of white mirrors has all of the
// light, and Lambert's law is Lambert's.
TEST(HeightField, OfFacetsThatHideNothingIsTheirs) {
  const auto run_of = [](const std::string& toml, Estimator estimator) {
    const Stack stack = parse_stack(toml, "test", "test");
    Simulation simulation(stack, make_plan(stack), direction_from_degrees(30, 0), estimator,
                          CellGrid{3, 6}, 11);
    simulation.advance(400000);
    return reduce(simulation);
  };
  const RunResult field =
      run_of("[[layer]]\nmedium = 'height_field'\nsurface = 'mirror'\nroughness = 0.1\n",
             Estimator::analog);
  const RunResult smith = run_of(
      "[substrate]\nbsdf = 'conductor'\neta = 1\nk = 0\nfresnel = 'one'\ndistribution = "
      "'beckmann'\nroughness = 0.1\nscattering = 'multiple'\n",
      Estimator::analog);
  int compared = 0;
  for (std::size_t k = 0; k < field.reflected.lobes[Order::all].value.size(); ++k) {
    const double a = field.reflected.lobes[Order::all].value[k],
                 b = smith.reflected.lobes[Order::all].value[k];
    const double error = std::hypot(field.reflected.lobes[Order::all].standard_error[k],
                                    smith.reflected.lobes[Order::all].standard_error[k]);
    if (a < 0.01) continue;
    EXPECT_NEAR(a, b, 5 * error) << k;
    ++compared;
  }
  EXPECT_GE(compared, 2);
  const RunResult diffuse =
      run_of("[[layer]]\nmedium = 'height_field'\nroughness = 0.01\nalbedo = 0.6\n",
             Estimator::next_event);
  for (const double f : diffuse.reflected.lobes[Order::all].value) EXPECT_NEAR(f, 0.6 / kPi, 2e-3);
}

}  // namespace
}  // namespace lamella
