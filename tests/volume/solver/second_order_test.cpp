#include "volume/solver/second_order.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/quadrature/depth_integrals.h"
#include "volume/solver/deterministic.h"
#include "volume/solver/mode_tail.h"

namespace lamella {
namespace {

using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;

TEST(DepthIntegrals, AgreeWithQuadrature) {
  const double rates[] = {0, 1e-9, 0.3, 0.3 + 1e-8, 7, 40};
  for (const double depth : {1e-3, 1.7})
    for (const double x : rates)
      for (const double y : rates) {
        const auto inner = [&](double t) {
          return std::exp(-y * t) * decay_integral(x, depth - t);
        };
        const double triangle = Rule::integrate(inner, 0.0, depth, 12, 1e-14);
        EXPECT_NEAR(decay_integral(x, y, depth) / triangle, 1, 1e-12) << x << ' ' << y;
        const auto cross = [&](double t) { return std::exp(-x * t - y * (depth - t)); };
        EXPECT_NEAR(crossing_integral(x, y, depth) / Rule::integrate(cross, 0.0, depth, 12, 1e-14),
                    1, 1e-12);
        for (const double z : rates) {
          const auto last = [&](double t) {
            return std::exp(-z * t) * crossing_integral(x, y, depth - t);
          };
          const double whole = Rule::integrate(last, 0.0, depth, 12, 1e-14);
          EXPECT_NEAR(crossing_integral(x, y, z, depth) / whole, 1, 1e-12)
              << x << ' ' << y << ' ' << z;
        }
      }
}

TEST(DepthIntegrals, HaveTheirLimits) {
  EXPECT_EQ(decay_integral(2, kInfinity), 0.5);
  EXPECT_EQ(decay_integral(2, 4, kInfinity), 0.125);
  EXPECT_NEAR(decay_integral(2, 4, 1e6), 0.125, 1e-15);
  EXPECT_EQ(crossing_integral(2, 4, kInfinity), 0);
  EXPECT_NEAR(decay_integral(1e200, 1, 1.0) * 1e200, -std::expm1(-1), 1e-14);
}

// Where few modes suffice, the solver's order 2 is exact to its nodes' error: 1.2e-7 at 40 nodes
// where both directions graze.
TEST(SecondOrder, EqualsTheSolversWhereModesSuffice) {
  struct Case {
    std::string name, toml;
  };
  const Case cases[] = {
      {"spheres", layer(kSphere, 0.9, 1.2)},
      {"half space", layer(henyey_greenstein(0.5), 0.8, kInfinity)},
      {"three layers", layer(kSphere, 0.9, 0.3) + layer(henyey_greenstein(-0.3), 0.5, 2) +
                           layer(kSphere, 0.9, 1e-3) + layer(kSphere, 0.4, 0.7)},
      {"thin over deep", layer(kSphere, 0.9, 1e-4) + layer(kIsotropic, 1, kInfinity)},
      {"black ground", layer(kSphere, 0.9, 0.5) + lambert_ground(0)}};
  for (const Case& c : cases) {
    const Stack stack = stack_of(c.toml);
    const DeterministicSolution s =
        solve_deterministic(stack, {.tolerance = 1e-10, .min_nodes = 40, .max_nodes = 40});
    const SecondOrder second(stack, 0);
    const std::vector<double> both{0.6, 0.02, -0.3};
    const std::vector<double> mu_i(both.begin(), both.begin() + (stack.is_open_below() ? 3 : 2));
    std::vector<double> mu_o{0.02, 0.6, 0.95};
    if (stack.is_open_below()) mu_o.insert(mu_o.end(), {-0.05, -0.7});
    const DeterministicField field = s.field(mu_i, mu_o);
    for (std::size_t i = 0; i < mu_i.size(); ++i)
      for (std::size_t o = 0; o < mu_o.size(); ++o)
        for (const double x : {0.0, 1.1}) {
          const double expected = field.multiple(i, o, x).order[1].r;
          const SecondOrder::Value value =
              second(direction_from_mu_phi(mu_i[i], 0), direction_from_mu_phi(mu_o[o], kPi - x),
                     1e-10 * expected);
          if (expected == 0) {
            EXPECT_EQ(value.f, 0) << c.name;
          } else {
            EXPECT_NEAR(value.f / expected, 1, 3e-7) << c.name << mu_i[i] << ' ' << mu_o[o];
          }
        }
  }
}

// The modes of steep flakes end late: 160 of them, 80 leave 2e-6.
TEST(SecondOrder, OfMirrorFlakesIsTheSumOfItsModes) {
  for (const std::string& medium : {sggx(0.5, "mirror"), vmf(0.5, "mirror"), fiber(0.6, "mirror"),
                                    sggx(0.5, "mirror") + "\nf0 = 0.04"}) {
    const Stack stack = stack_of(layer(medium, 0.9, 1.5) + layer(kSphere, 0.7, 0.3));
    const DeterministicSolution s = solve_deterministic(stack, {.tolerance = 1e-9,
                                                                .min_nodes = 32,
                                                                .max_nodes = 32,
                                                                .max_modes = 160,
                                                                .max_seconds = 1e4});
    const SecondOrder second(stack, 0);
    const double mu_i[] = {0.6, -0.3}, mu_o[] = {0.45, 0.95, -0.9};
    const DeterministicField field = s.field(mu_i, mu_o);
    for (int i = 0; i < 2; ++i)
      for (int o = 0; o < 3; ++o) {
        const double expected = field.multiple(i, o, 0.7).order[1].r;
        const SecondOrder::Value value =
            second(direction_from_mu_phi(mu_i[i], 0), direction_from_mu_phi(mu_o[o], kPi - 0.7),
                   1e-10 * expected);
        EXPECT_NEAR(value.f / expected, 1, 6e-7) << medium << ' ' << mu_i[i] << ' ' << mu_o[o];
      }
  }
}

// Grazing reflection, straight transmission and beside it, where the modes fall slowest.
TEST(SecondOrder, HasModesThatSumToItsValues) {
  for (const std::string& medium :
       {sggx(0.5, "mirror"), vmf(0.4, "mirror"), sggx(0.5, "mirror") + "\nf0 = 0.04"}) {
    const SecondOrder second(stack_of(layer(medium, 0.9, 1.5) + layer(kSphere, 0.7, 0.3)), 0);
    const double pairs[][2] = {{0.6, 0.45}, {0.17, 0.03}, {-0.3, 0.9}, {0.6, -0.6}, {0.6, -0.58}};
    for (const auto& [mu_i, mu_o] : pairs) {
      const SecondOrder::Modes coarse = second.modes(mu_i, mu_o, 160, 1e-5);
      const SecondOrder::Modes fine = second.modes(mu_i, mu_o, 160, 1e-13);
      const Eigen::ArrayXd off = (coarse.f - fine.f).abs();
      EXPECT_LE(2 * off.sum() - off[0], coarse.error) << medium << ' ' << mu_i << ' ' << mu_o;
      const ModeTail tail = fit_mode_tail({fine.f.data(), 160});
      for (const double x : {0.05, 0.7}) {
        double sum = tail.sum(x);
        for (int m = 0; m < 160; ++m) sum += (m == 0 ? 1 : 2) * fine.f[m] * std::cos(m * x);
        const SecondOrder::Value value =
            second(direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, kPi - x), 1e-12);
        EXPECT_NEAR(sum / value.f, 1, 2e-8 + (tail.error + value.error) / value.f)
            << medium << ' ' << mu_i << ' ' << mu_o << ' ' << x;
      }
    }
  }
}

// Sums of modes alone, where 16 nodes are far from enough for the modes of order 2.
TEST(SecondOrder, IsIntegratedForThoseWhoAskForModes) {
  const Stack stack = stack_of(layer(sggx(0.5, "mirror"), 0.9, 0.5) + layer(kSphere, 0.7, 0.3) +
                               lambert_ground(0.4));
  const DeterministicSolution s =
      solve_deterministic(stack, {.tolerance = 5e-7, .min_nodes = 12, .max_nodes = 16});
  ASSERT_GT(s.accuracy().second_error, 2e-6);
  const double mu_i[] = {0.17, 0.6}, mu_o[] = {0.02, 0.17, 0.6, 0.95};
  const DeterministicField modes = s.field(mu_i, mu_o, true), points = s.field(mu_i, mu_o);
  for (int i = 0; i < 2; ++i)
    for (int o = 0; o < 4; ++o)
      for (const double x : {0.0, 0.7}) {
        const double expected = points.multiple_refined(i, o, x).order[1].r;
        const double left_out = 3e-7 * modes.scale(0, i, o);
        EXPECT_NEAR(modes.multiple(i, o, x).order[1].r, expected, left_out) << i << ' ' << o;
        double sum = 0;
        for (int m = 0; m < modes.modes(0); ++m)
          sum += (m == 0 ? 1 : 2) * modes.mode(0, 1, m, i, o) * std::cos(m * x);
        EXPECT_NEAR(sum, expected, left_out) << i << ' ' << o;
      }
}

TEST(SecondOrder, IsReciprocalAtTheHardPairs) {
  for (const std::string& medium : {sggx(0.3, "mirror"), vmf(0.3, "mirror")}) {
    const SecondOrder second(stack_of(layer(medium, 0.9, 1.5)), 0);
    const double pairs[][3] = {{0.01, 0.012, 0}, {0.01, 0.02, 1e-3}, {0.6, 0.05, 0.01}};
    for (const auto& [mu_i, mu_o, x] : pairs) {
      const Direction a = direction_from_mu_phi(mu_i, 0), b = direction_from_mu_phi(mu_o, kPi - x);
      const double forth = second(a, b, 1e-10).f;
      EXPECT_NEAR(second(b, a, 1e-10).f / forth, 1, 1e-8) << medium << ' ' << mu_i << ' ' << mu_o;
    }
  }
}

}  // namespace
}  // namespace lamella
