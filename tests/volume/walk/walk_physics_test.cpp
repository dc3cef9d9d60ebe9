#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "phase/medium/lambert_sphere.h"
#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/stacks.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::layer;
using testing::plan_of;
using testing::point_estimate;
using testing::stack_from;
using testing::z_between;

std::unique_ptr<Simulation> at_points(const Stack& stack, Direction wi,
                                      const std::vector<Direction>& points, std::uint64_t walks,
                                      std::uint64_t seed = 1) {
  auto simulation = std::make_unique<Simulation>(stack, plan_of(stack), wi, points, seed);
  simulation->advance(testing::soaked(walks));
  return simulation;
}

// Totals per order on one side, as estimates.
Estimate energy(const Simulation& s, bool up, int order) {
  return batch_estimate(s.batches(), [&](const BatchTally& b) {
    return (up ? b.energy.up : b.energy.down)[order][0];
  });
}

std::unique_ptr<Simulation> analog(const Stack& stack, Direction wi, std::uint64_t walks,
                                   std::uint64_t seed = 1) {
  auto simulation = std::make_unique<Simulation>(stack, plan_of(stack), wi, Estimator::analog,
                                                 CellGrid{2, 2, false}, seed);
  simulation->advance(testing::soaked(walks));
  return simulation;
}

class WalkPhysics : public testing::OnEveryIsa {};

TEST_P(WalkPhysics, IsotropicSlabMatchesVanDeHulst1980Table12) {
  // Albedo 0.8, optical depth 2, pi f at mu_o = 0.5.
  const Stack stack = load_stack("isotropic_slab");
  const auto check = [&](double mu_i, double sign, double expected) {
    const auto s = at_points(stack, direction_from_mu_phi(mu_i, 0),
                             {direction_from_mu_phi(sign * 0.5, 1)}, 100000);
    const Estimate f = point_estimate(*s, kTallyOrders, 0, 1);
    // The table prints five digits.
    EXPECT_NEAR(kPi * f.value, expected, allowed_z() * kPi * f.standard_error + 5e-6)
        << mu_i << ' ' << sign;
  };
  const double mu[] = {1, 0.9, 0.7, 0.5, 0.3, 0.1};
  const double reflected[] = {0.28616, 0.30277, 0.34188, 0.39102, 0.45353, 0.53214};
  for (int k = 0; k < 6; ++k) check(mu[k], 1, reflected[k]);
  const double mu_t[] = {1, 0.9, 0.7, 0.3, 0.1};
  const double transmitted[] = {0.14864, 0.14731, 0.13963, 0.09425, 0.06601};
  for (int k = 0; k < 5; ++k) check(mu_t[k], -1, transmitted[k]);
}

// Chandrasekhar's H by iteration of 1 / H(mu) = sqrt(1 - c) + c/2 integral of x H(x) / (mu + x) dx
// on midpoints in x = t^2, for the tests alone.
double h_function(double albedo, double mu) {
  constexpr int n = 800;
  std::vector<double> x(n), w(n), h(n, 1.0);
  for (int k = 0; k < n; ++k) {
    const double t = (k + 0.5) / n;
    x[k] = t * t;
    w[k] = 2 * t / n;
  }
  const auto value = [&](double m) {
    double sum = 0;
    for (int k = 0; k < n; ++k) sum += w[k] * x[k] * h[k] / (m + x[k]);
    return 1 / (std::sqrt(1 - albedo) + albedo / 2 * sum);
  };
  for (int sweep = 0; sweep < 200; ++sweep) {
    std::vector<double> next(n);
    for (int k = 0; k < n; ++k) next[k] = value(x[k]);
    for (int k = 0; k < n; ++k) h[k] = (h[k] + next[k]) / 2;  // undamped, it swings for ever
  }
  return value(mu);
}

TEST_P(WalkPhysics, IsotropicHalfSpaceMatchesChandrasekharsHFunction) {
  EXPECT_NEAR(h_function(1, 1), 2.907810529, 5e-4);  // what the rule above is good for
  const Stack stack = load_stack("isotropic_halfspace");
  for (const double mu_i : {1.0, 0.5, 0.1})
    for (const double mu_o : {0.9, 0.3}) {
      const auto s =
          at_points(stack, direction_from_mu_phi(mu_i, 0), {direction_from_mu_phi(mu_o, 2)}, 50000);
      const Estimate f = point_estimate(*s, kTallyOrders, 0, 1);
      const double exact =
          0.9 / (4 * kPi) * h_function(0.9, mu_i) * h_function(0.9, mu_o) / (mu_i + mu_o);
      EXPECT_NEAR(f.value, exact, allowed_z() * f.standard_error + 1e-5 * exact)
          << mu_i << ' ' << mu_o;
    }
}

TEST_P(WalkPhysics, ReflectionIsReciprocalForEveryMediumButTiltedOneSidedFlakes) {
  const Direction a = direction_from_degrees(25, 10), b = direction_from_degrees(70, 130);
  for (const std::string& medium : testing::every_medium()) {
    const Stack stack = stack_from(layer(medium + "\nalbedo = 0.9\nthickness = 2") +
                                   layer("medium = 'henyey_greenstein'\nthickness = 0.5"));
    if (!stack.is_reciprocal()) continue;
    const Estimate ab = point_estimate(*at_points(stack, a, {b}, 60000), kTallyOrders, 0, 1);
    const Estimate ba = point_estimate(*at_points(stack, b, {a}, 60000, 2), kTallyOrders, 0, 1);
    EXPECT_LT(std::abs(z_between(ab, ba)), allowed_z()) << medium;
  }
}

TEST_P(WalkPhysics, OneSidedTransmissionFollowsTheLawOfTheReadme) {
  const Direction above = direction_from_degrees(40, 0), below = direction_from_degrees(120, 70);
  for (const char* flake : {"lambert", "mirror"}) {
    const Stack stack =
        stack_from(layer(std::string("medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 0.9\n"
                                     "thickness = 1.5\nflake = '") +
                         flake + "'"));
    const Estimate down =
        point_estimate(*at_points(stack, above, {below}, 100000), kTallyOrders, 0, 1);
    const Estimate up =
        point_estimate(*at_points(stack, below, {above}, 100000, 2), kTallyOrders, 0, 1);
    const double law = std::exp(-stack.one_sidedness());
    EXPECT_NEAR(law, 0.5507, 5e-5);
    const Estimate scaled{law * up.value, law * up.standard_error};
    EXPECT_LT(std::abs(z_between(down, scaled)), allowed_z()) << flake;
  }
}

TEST_P(WalkPhysics, TiltedOneSidedFlakesAreNotReciprocalWhenTheirNormalsLean) {
  // The law's premise: with a tilted mean normal exp(rho B_xy . dx) does not cancel over a path.
  const Stack stack = stack_from(layer(
      "medium = 'vmf_flake'\nroughness = 0.3\naxis = [1, 0, 0.2]\nalbedo = 1\nthickness = 3"));
  EXPECT_FALSE(stack.is_reciprocal());
  const Direction a = direction_from_degrees(60, 0), b = direction_from_degrees(60, 180);
  const Estimate ab = point_estimate(*at_points(stack, a, {b}, 60000), kTallyOrders, 0, 1);
  const Estimate ba = point_estimate(*at_points(stack, b, {a}, 60000, 2), kTallyOrders, 0, 1);
  EXPECT_GT(std::abs(z_between(ab, ba)), 10);
}

TEST_P(WalkPhysics, OneLayerEqualsTenOfATenthAndAnUnequalSplit) {
  for (const std::string& medium : testing::every_medium()) {
    const auto keys = [&](double thickness) {
      return layer(medium + "\nalbedo = 0.8\nthickness = " + std::to_string(thickness));
    };
    std::string ten;
    for (int k = 0; k < 10; ++k) ten += keys(0.1);
    const Direction wi = direction_from_degrees(50, 20);
    const auto whole = analog(stack_from(keys(1)), wi, 100000);
    const auto tenths = analog(stack_from(ten), wi, 100000, 2);
    const auto split = analog(stack_from(keys(0.3) + keys(0.7)), wi, 100000, 3);
    for (const bool up : {true, false})
      for (int o = 0; o < kTallyOrders; ++o) {
        EXPECT_LT(std::abs(z_between(energy(*whole, up, o), energy(*tenths, up, o))), allowed_z())
            << medium << ' ' << up << ' ' << o;
        EXPECT_LT(std::abs(z_between(energy(*whole, up, o), energy(*split, up, o))), allowed_z())
            << medium << ' ' << up << ' ' << o;
      }
  }
}

TEST_P(WalkPhysics, UniformLambertianFlakesAreLambertSpheresOfAQuarterOfTheDensity) {
  const Stack flakes =
      stack_from(layer("medium = 'vmf_flake'\nroughness = 1\nalbedo = 0.9\nthickness = 4"));
  const Stack spheres =
      stack_from(layer("medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = 4\ndensity = 0.25"));
  const Direction wi = direction_from_degrees(60, 0);
  const auto a = analog(flakes, wi, 300000), b = analog(spheres, wi, 300000, 2);
  for (const bool up : {true, false})
    for (int o = 0; o < kTallyOrders; ++o)
      EXPECT_LT(std::abs(z_between(energy(*a, up, o), energy(*b, up, o))), allowed_z()) << up << o;
}

TEST_P(WalkPhysics, IsotropicMirrorFlakesScatterIsotropically) {
  const Stack flakes =
      stack_from(layer("medium = 'sggx'\nroughness = 1\nalbedo = 0.9\nthickness = 2"));
  const Stack isotropic =
      stack_from(layer("medium = 'henyey_greenstein'\nalbedo = 0.9\nthickness = 2"));
  const Direction wi = direction_from_degrees(60, 0);
  const auto a = analog(flakes, wi, 300000), b = analog(isotropic, wi, 300000, 2);
  for (const bool up : {true, false})
    for (int o = 0; o < kTallyOrders; ++o)
      EXPECT_LT(std::abs(z_between(energy(*a, up, o), energy(*b, up, o))), allowed_z()) << up << o;
}

TEST_P(WalkPhysics, SmoothLambertianFlakesTendToLambert) {
  // At r = 0 the half space is Lambert's exactly: every walk ends after one event, f = albedo / pi.
  const Stack flat =
      stack_from(layer("medium = 'vmf_flake'\nroughness = 0\nalbedo = 0.7\nthickness = inf"));
  const Direction wi = direction_from_degrees(70, 0), wo = direction_from_degrees(20, 100);
  const auto s = at_points(flat, wi, {wo}, 20000);
  EXPECT_EQ(s->collisions(), s->walks());
  const Estimate f = point_estimate(*s, kTallyOrders, 0, 1);
  EXPECT_NEAR(f.value, 0.7 / kPi, allowed_z() * f.standard_error + 1e-14);  // rounding of the sum
  double last = 1;
  for (const char* r : {"0.1", "0.01", "0.001"}) {
    const Stack rough = stack_from(layer(
        std::string("medium = 'vmf_flake'\nalbedo = 0.7\nthickness = inf\nroughness = ") + r));
    const Estimate g = point_estimate(*at_points(rough, wi, {wo}, 60000), kTallyOrders, 0, 1);
    const double off = std::abs(g.value - 0.7 / kPi);
    EXPECT_LT(off, last + allowed_z() * g.standard_error) << r;
    last = off;
  }
  EXPECT_LT(last, 0.02 * 0.7 / kPi);
}

TEST_P(WalkPhysics, OneSidedSlabOfFlatFlakesPassesAllLightFromBelow) {
  const Stack slab =
      stack_from(layer("medium = 'vmf_flake'\nroughness = 0\nalbedo = 0.7\nthickness = 1.5"));
  EXPECT_DOUBLE_EQ(slab.uncollided(direction_from_degrees(150, 0)), 1);
  EXPECT_NEAR(slab.uncollided(direction_from_degrees(80, 0)), std::exp(-1.5), 1e-15);
}

TEST_P(WalkPhysics, DeltaFlakesReflectIntoTheirSpecularLobeAlone) {
  const Stack slab = stack_from(layer(
      "medium = 'vmf_flake'\nroughness = 0\nflake = 'mirror'\nalbedo = 0.8\nthickness = 1.5"));
  Simulation s(slab, plan_of(slab), direction_from_degrees(30, 0), Estimator::analog,
               CellGrid{4, 8, true}, 1);
  s.advance(100000);
  const RunResult run = reduce(s);
  // Down once, up for ever: 0.8 (1 - exp(-1.5)).
  EXPECT_NEAR(run.reflected.specular[0].value, 0.8 * -std::expm1(-1.5),
              allowed_z() * run.reflected.specular[0].standard_error);
  EXPECT_EQ(run.reflected.specular[0].value, run.reflected.total[0].value);
  for (const double f : run.reflected.lobes[Order::all].value) EXPECT_EQ(f, 0);
}

// vMF flakes in a slab with VMF Diffuse's null collisions: majorant rho in every direction, a
// normal from D, a real collision with the probability of its projected cosine. Shares no formula
// with the engine but D's sampler: neither sigma, nor its table, nor the visible normals.
std::array<double, 4> null_collision_energies(double roughness, double depth, Direction wi,
                                              int walks) {
  const Vmf flakes(vmf_alpha(roughness), {0, 0, 1});
  std::array<double, 4> reflected{};
  for (int n = 0; n < walks; ++n) {
    RandomStream stream(99, n, StreamPurpose::test);
    Direction w = wi;
    double y = 0;
    int order = 0;
    for (;;) {
      y += stream.exponential() * w.z;  // light travels along -w
      if (y < 0) {
        if (order > 0) reflected[std::min(order, 4) - 1] += 1.0 / walks;
        break;
      }
      if (y > depth) break;
      const Direction m = flakes.sample_normal(stream);
      if (stream.uniform() >= dot(w, m)) continue;
      ++order;
      const double u1 = stream.uniform(), u2 = stream.uniform();
      w = -cosine_hemisphere(m, u1, u2);
    }
  }
  return reflected;
}

TEST_P(WalkPhysics, VisibleNormalsAgreeWithNullCollisions) {
  const int walks = static_cast<int>(testing::soaked(200000));
  for (const double r : {0.2, 0.5, 0.9}) {
    const Direction wi = direction_from_degrees(65, 0);
    const auto expected = null_collision_energies(r, 2, wi, walks);
    const Stack stack =
        stack_from(layer("medium = 'vmf_flake'\nthickness = 2\nroughness = " + std::to_string(r)));
    const auto s = analog(stack, wi, walks);
    for (int o = 0; o < kTallyOrders; ++o) {
      const double p = expected[o];
      const Estimate other{p, std::sqrt(p * (1 - p) / walks)};
      EXPECT_LT(std::abs(z_between(energy(*s, true, o), other)), allowed_z()) << r << ' ' << o;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, WalkPhysics, ::testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return to_text(isa.param); });

}  // namespace
}  // namespace lamella
