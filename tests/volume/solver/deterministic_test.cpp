#include "volume/solver/deterministic.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "phase/stack/single_scattering.h"
#include "tests/volume/solver/deterministic_stacks.h"

namespace lamella {
namespace {

DeterministicSolution solved(const std::string& toml, double tolerance = 1e-7) {
  const DeterministicSolution s = solve_deterministic(stack_of(toml), {.tolerance = tolerance});
  EXPECT_TRUE(s.accuracy().reached) << toml << s.accuracy().error;
  return s;
}

double f_all(const DeterministicSolution& s, double mu_i, double mu_o, double phi = 0.7) {
  return s.f(direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, phi)).order[Order::all].r;
}

TEST(Deterministic, IsotropicSlabMatchesVanDeHulst1980Table12) {
  // All five printed digits: half a unit of the last, and 1e-8 of our own.
  const DeterministicSolution s = solved(layer(kIsotropic, 0.8, 2));
  const double mu[] = {1, 0.9, 0.7, 0.5, 0.3, 0.1};
  const double reflected[] = {0.28616, 0.30277, 0.34188, 0.39102, 0.45353, 0.53214};
  const double transmitted[] = {0.14864, 0.14731, 0.13963, 0, 0.09425, 0.06601};
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(kPi * f_all(s, mu[k], 0.5), reflected[k], 5.01e-6) << mu[k];
    if (transmitted[k] > 0) {
      EXPECT_NEAR(kPi * f_all(s, mu[k], -0.5), transmitted[k], 5.01e-6) << mu[k];
    }
  }
}

// H(mu) of isotropic scattering: log H = -mu / pi times the integral over theta in [0, pi / 2] of
// log(1 - albedo theta cot theta) / (cos^2 + mu^2 sin^2). Chandrasekhar 1960, chapter V.
double h_function(double albedo, double mu) {
  boost::math::quadrature::tanh_sinh<double> rule;
  const auto integrand = [&](double theta) {
    const double c = std::cos(theta), s = std::sin(theta);
    const double t2 = theta * theta;
    const double less = theta < 0.02 ? t2 / 3 + t2 * t2 / 45 : 1 - theta * c / s;  // 1 - theta cot
    return std::log((1 - albedo) + albedo * std::max(less, 1e-300)) / (c * c + mu * mu * s * s);
  };
  return std::exp(-mu / kPi * rule.integrate(integrand, 0.0, kPi / 2));
}

TEST(Deterministic, IsotropicHalfSpaceIsTheProductOfHFunctions) {
  EXPECT_NEAR(h_function(1, 1), 2.907810529, 1e-9);
  const double mu[] = {0.01, 0.1, 0.5, 1.0};
  for (const double albedo : {0.2, 0.8, 0.99, 1.0}) {
    const Stack stack = stack_of(layer(kIsotropic, albedo, kInfinity));
    const DeterministicField field = solve_deterministic(stack, {.tolerance = 1e-8}).field(mu, mu);
    for (int i = 0; i < 4; ++i)
      for (int o = 0; o < 4; ++o) {
        const Direction wi = direction_from_mu_phi(mu[i], 0), wo = direction_from_mu_phi(mu[o], 1);
        const double f = field.multiple(i, o, kPi - 1).order[Order::all].r +
                         single_scattering(stack, wi, wo).layers.r;
        const double expected = albedo / (4 * kPi) * h_function(albedo, mu[i]) *
                                h_function(albedo, mu[o]) / (mu[i] + mu[o]);
        EXPECT_NEAR(f / expected, 1, 1e-8) << albedo << ' ' << mu[i] << ' ' << mu[o];
      }
  }
}

TEST(Deterministic, LambertSpheresAreStableToEightDigitsUnderRefinement) {
  const double mu[] = {0.01, 0.2, 1};
  for (const double thickness : {1.0, kInfinity}) {
    const Stack stack = stack_of(layer(kSphere, 0.9, thickness));
    const DeterministicOptions coarse{.tolerance = 1e-9, .min_nodes = 32, .max_nodes = 32};
    const DeterministicOptions fine{.tolerance = 1e-9, .min_nodes = 44, .max_nodes = 44};
    const DeterministicField a = solve_deterministic(stack, coarse).field(mu, mu),
                             b = solve_deterministic(stack, fine).field(mu, mu);
    for (int i = 0; i < 3; ++i)
      for (int o = 0; o < 3; ++o)
        for (const double x : {0.0, 1.0, 3.0})
          EXPECT_NEAR(a.multiple(i, o, x).order[Order::all].r,
                      b.multiple(i, o, x).order[Order::all].r, 1e-8 * b.mean(0, i, o))
              << thickness << ' ' << mu[i] << ' ' << mu[o];
  }
}

TEST(Deterministic, NarrowPeaksAndFlakesReachEightDigits) {
  for (const auto& [medium, nodes] :
       {std::pair{henyey_greenstein(0.8), 64}, std::pair{sggx(0.05, "lambert"), 128}}) {
    const DeterministicSolution s = solve_deterministic(
        stack_of(layer(medium, 0.9, 1.5)),
        {.tolerance = 1e-8, .min_nodes = nodes / 4 * 3, .max_nodes = nodes, .max_seconds = 1e4});
    EXPECT_TRUE(s.accuracy().reached) << medium << ' ' << s.accuracy().error;
  }
}

// Mirror flakes at their hard places: both directions grazing, straight on and close to it.
const double kHardPairs[][3] = {{0.01, 0.01, 0},  {0.01, 0.02, 0.3}, {0.07, 0.13, 0},
                                {0.6, 0.45, 2},   {0.6, -0.6, 0},    {0.6, -0.58, 0.01},
                                {0.01, -0.01, 0}, {0.02, -0.9, 1},   {-0.3, 0.31, 0}};

void expect_stable(const std::string& medium, double thickness, double tolerance, int nodes,
                   double limit) {
  const Stack stack = stack_of(layer(medium, 0.9, thickness));
  const int finer = nodes * 4 / 3;
  const auto solve = [&](int n) {
    return solve_deterministic(
        stack,
        {.tolerance = tolerance, .min_nodes = n * 3 / 4, .max_nodes = n, .max_seconds = 1e4});
  };
  const DeterministicSolution coarse = solve(nodes), fine = solve(finer);
  for (const auto& [mu_i, mu_o, x] : kHardPairs) {
    if (!stack.is_open_below() && (mu_i < 0 || mu_o < 0)) continue;
    const Direction wi = direction_from_mu_phi(mu_i, 0), wo = direction_from_mu_phi(mu_o, kPi - x);
    const DeterministicValue a = coarse.f(wi, wo), b = fine.f(wi, wo);
    const double change = std::abs(a.order[Order::all].r - b.order[Order::all].r);
    EXPECT_LE(change, a.error.r) << medium << ' ' << mu_i << ' ' << mu_o << ' ' << x;
    EXPECT_LE(b.error.r, limit * b.order[Order::all].r)
        << medium << ' ' << mu_i << ' ' << mu_o << ' ' << x;
    if (is_soak())
      std::printf(
          "%s, depth %g: f(%g, %g, x = %g) = %.10e, changes by %.1e, stated %.1e and %.1e\n",
          medium.c_str(), thickness, mu_i, mu_o, x, b.order[Order::all].r,
          change / b.order[Order::all].r, a.error.r / a.order[Order::all].r,
          b.error.r / b.order[Order::all].r);
  }
  if (is_soak())
    std::printf("  %d and %d nodes, %d modes, accuracy %.1e%s, %.1f s\n", coarse.accuracy().nodes,
                fine.accuracy().nodes, fine.accuracy().modes, fine.accuracy().error,
                fine.accuracy().reached ? "" : " (not reached)", fine.accuracy().seconds);
}

TEST(Deterministic, MirrorFlakesAreStableAtGrazingAndStraightOn) {
  expect_stable(sggx(0.6, "mirror"), 1.5, 1e-5, 16, 1e-4);
  expect_stable(vmf(0.6, "mirror"), kInfinity, 1e-5, 16, 1e-4);
}

TEST(DeterministicSoak, MirrorFlakesSettleUnderRefinement) {
  if (!is_soak()) GTEST_SKIP() << "minutes: set LAMELLA_SOAK";
  // From 24 nodes, where their error is 4e-7 (0.5) and 4e-6 (0.3) of the mean, like their fourth
  // power; f itself may be a few times below the mean.
  for (const double roughness : {0.5, 0.3})
    for (const double thickness : {1.5, kInfinity}) {
      const double limit = roughness < 0.4 ? 1e-6 : 1e-7;
      expect_stable(sggx(roughness, "mirror"), thickness, 1e-8, 48, limit);
      expect_stable(vmf(roughness, "mirror"), thickness, 1e-8, 48, limit);
    }
}

TEST(Deterministic, ReflectionIsReciprocal) {
  for (const std::string& medium :
       {kSphere, henyey_greenstein(0.6), sggx(0.4, "mirror"), sggx(0.4, "lambert"),
        vmf(0.4, "mirror"), vmf(0.1, "lambert"), fiber(0.5, "lambert")}) {
    const DeterministicOptions options{.tolerance = 1e-3, .max_nodes = 16};
    const DeterministicSolution s =
        solve_deterministic(stack_of(layer(medium, 0.9, 1.3) + layer(kSphere, 0.7, 0.4)), options);
    for (const double side : {1.0, -1.0}) {
      const double mu[] = {side * 0.05, side * 0.4, side * 0.9};
      const DeterministicField field = s.field(mu, mu);
      for (int i = 0; i < 3; ++i)
        for (int o = 0; o < i; ++o)
          EXPECT_NEAR(field.multiple(i, o, 0.5).order[Order::all].r /
                          field.multiple(o, i, 0.5).order[Order::all].r,
                      1, 1e-10)
              << medium << mu[i] << ' ' << mu[o];
    }
  }
}

TEST(Deterministic, TransmissionOfOneSidedFlakesObeysTheExponentialLaw) {
  for (const std::string& medium :
       {vmf(0.5, "lambert"), vmf(0.05, "lambert"), vmf(0.3, "mirror")}) {
    const Stack stack = stack_of(layer(medium, 0.95, 1.5) + layer(kSphere, 0.8, 0.2) +
                                 layer(vmf(0.8, "lambert"), 0.7, 0.6));
    const DeterministicSolution s =
        solve_deterministic(stack, {.tolerance = 1e-3, .max_nodes = 16, .max_modes = 48});
    const double ratio = std::exp(-stack.one_sidedness());
    for (const double mi : {0.1, 0.7})
      for (const double mo : {0.2, 0.9})
        EXPECT_NEAR(f_all(s, mi, -mo) / f_all(s, -mo, mi) / ratio, 1, 1e-10) << medium << mi;
  }
}

TEST(Deterministic, OneLayerEqualsItsUnequalParts) {
  for (const std::string& medium : {kSphere, henyey_greenstein(0.5), sggx(0.5, "lambert"),
                                    vmf(0.5, "lambert"), sggx(0.6, "mirror")}) {
    const DeterministicOptions options{
        .tolerance = 1e-3, .min_nodes = 16, .max_nodes = 16, .max_modes = 48};
    const DeterministicSolution one =
        solve_deterministic(stack_of(layer(medium, 0.9, 1.6)), options);
    const DeterministicSolution parts = solve_deterministic(
        stack_of(layer(medium, 0.9, 0.03) + layer(medium, 0.9, 1.2) + layer(medium, 0.9, 0.37)),
        options);
    for (const double mi : {0.02, 0.6, -0.3})
      for (const double mo : {0.05, 0.8, -0.7})
        EXPECT_NEAR(f_all(parts, mi, mo) / f_all(one, mi, mo), 1, 1e-9)
            << medium << ' ' << mi << ' ' << mo;
  }
}

TEST(Deterministic, ManyThinLayersEqualOne) {
  std::string toml;
  for (int k = 0; k < 500; ++k)
    toml += layer(vmf(0.5, "lambert"), 0.9, 0.001) + layer(vmf(0.5, "lambert"), 0.9, 0.003);
  const DeterministicOptions options{.tolerance = 1e-2, .min_nodes = 12, .max_nodes = 12};
  const DeterministicSolution many = solve_deterministic(stack_of(toml), options);
  const DeterministicSolution one =
      solve_deterministic(stack_of(layer(vmf(0.5, "lambert"), 0.9, 2)), options);
  const double mu_i[] = {0.3, -0.6}, mu_o[] = {0.05, 0.8, -0.7};
  const DeterministicField a = many.field(mu_i, mu_o), b = one.field(mu_i, mu_o);
  for (int i = 0; i < 2; ++i)
    for (int o = 0; o < 3; ++o)
      EXPECT_NEAR(a.multiple(i, o, 1).order[Order::all].r / b.multiple(i, o, 1).order[Order::all].r,
                  1, 1e-8)
          << mu_i[i] << ' ' << mu_o[o];
}

TEST(Deterministic, UniformLambertianFlakesAreSpheresOfAQuarterOfTheDensity) {
  const DeterministicSolution flakes = solved(layer(vmf(1, "lambert"), 0.8, 6));
  const DeterministicSolution spheres = solved(layer(kSphere, 0.8, 1.5));
  for (const double mi : {0.02, 0.6, -0.3})
    for (const double mo : {0.05, 0.8, -0.7})
      EXPECT_NEAR(f_all(flakes, mi, mo) / f_all(spheres, mi, mo), 1, 4e-7) << mi << ' ' << mo;
}

TEST(Deterministic, IsotropicMirrorFlakesAreIsotropicParticles) {
  const DeterministicSolution flakes = solved(layer(sggx(1, "mirror"), 0.8, 1.5));
  const DeterministicSolution particles = solved(layer(kIsotropic, 0.8, 1.5));
  for (const double mi : {0.02, 0.6, -0.3})
    for (const double mo : {0.05, 0.8, -0.7})
      EXPECT_NEAR(f_all(flakes, mi, mo) / f_all(particles, mi, mo), 1, 4e-7) << mi << ' ' << mo;
}

TEST(Deterministic, OrdersScaleWithPowersOfTheAlbedo) {
  const std::string medium = vmf(0.6, "lambert");
  const DeterministicOptions options{.tolerance = 1e-3, .min_nodes = 12, .max_nodes = 12};
  const DeterministicSolution white = solve_deterministic(stack_of(layer(medium, 1, 2)), options);
  const DeterministicSolution grey = solve_deterministic(stack_of(layer(medium, 0.5, 2)), options);
  for (const double mo : {0.3, -0.8}) {
    const Direction wi = direction_from_mu_phi(0.6, 0), wo = direction_from_mu_phi(mo, 2);
    const DeterministicValue a = white.f(wi, wo), b = grey.f(wi, wo);
    double sum = 0;
    for (int order = 0; order < 4; ++order) sum += a.order[order].r;
    EXPECT_NEAR(sum / a.order[Order::all].r, 1, 1e-14);
    for (int order = 0; order < 3; ++order)
      EXPECT_NEAR(b.order[order].r / a.order[order].r, std::pow(0.5, order + 1), 1e-12) << order;
  }
}

TEST(Deterministic, ChannelsAreIndependent) {
  const Stack rgb = stack_of(
      "[[layer]]\nmedium = \"sggx\"\nroughness = 0.7\nf0 = [0.04, 1, 0.04]\nalbedo = [0.9, 0.5, "
      "0.9]\nthickness = 1.0\n" +
      lambert_ground(0.5));
  const DeterministicOptions options{.tolerance = 1e-3, .min_nodes = 12, .max_nodes = 12};
  const DeterministicSolution s = solve_deterministic(rgb, options);
  const DeterministicSolution green = solve_deterministic(
      stack_of(layer(sggx(0.7, "mirror"), 0.5, 1) + lambert_ground(0.5)), options);
  const Direction wi = direction_from_mu_phi(0.6, 0), wo = direction_from_mu_phi(0.3, 2);
  const Rgb value = s.f(wi, wo).order[Order::all];
  EXPECT_EQ(value.r, value.b);
  EXPECT_LT(value.r, value.g);
  EXPECT_NEAR(value.g / green.f(wi, wo).order[Order::all].r, 1, 1e-13);
}

TEST(Deterministic, BareGroundIsLambertian) {
  const DeterministicSolution s =
      solve_deterministic(stack_of(layer(kSphere, 0.5, 0) + lambert_ground(0.6)));
  EXPECT_NEAR(f_all(s, 0.3, 0.8), 0.6 / kPi, 1e-15);
  const double mu[] = {0.4};
  const DeterministicEnergies e = s.energies(mu)[0];
  EXPECT_NEAR(e.reflected[0].r, 0.6, 1e-14);
  EXPECT_NEAR(e.absorbed.r, 0.4, 1e-14);
}

TEST(Deterministic, WhatCannotBeSolvedIsRefused) {
  EXPECT_THROW(
      (void)solve_deterministic(stack_of(
          "[[layer]]\nmedium = \"sggx\"\nroughness = 0.5\naxis = [1, 0, 0]\nthickness = 1.0\n")),
      std::invalid_argument);
  EXPECT_THROW((void)solve_deterministic(stack_of(layer(vmf(0, "mirror"), 1, 1))),
               std::invalid_argument);
  const DeterministicSolution half = solved(layer(kSphere, 0.9, kInfinity), 1e-4);
  const double below[] = {-0.5};
  EXPECT_THROW((void)half.energies(below), std::invalid_argument);
  EXPECT_THROW((void)half.f({0, 0, -1}, {0, 0, 1}), std::invalid_argument);
  EXPECT_THROW((void)half.f({1, 0, 0}, {0, 1, 0}), std::invalid_argument);
}

TEST(Deterministic, ALimitThatIsTooLowIsReported) {
  const DeterministicSolution s = solve_deterministic(
      stack_of(layer(henyey_greenstein(0.9), 0.9, 2)), {.tolerance = 1e-9, .max_nodes = 12});
  EXPECT_FALSE(s.accuracy().reached);
  EXPECT_GT(s.accuracy().error, 1e-9);
  EXPECT_LE(s.accuracy().nodes, 12);
}

}  // namespace
}  // namespace lamella
