#include <gtest/gtest.h>

#include <cmath>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/solver/deterministic.h"
#include "volume/solver/mode_tail.h"
#include "volume/solver/second_order.h"

namespace lamella {
namespace {

std::string smooth(double ior) {
  return fmt::format("[[layer]]\ninterface = \"smooth\"\nior = {}\n", ior);
}

Direction along(double mu, double phi) { return direction_from_mu_phi(mu, phi); }

struct Case {
  std::string name, toml;
};

// Where few modes suffice, the sums of modes are exact to the error of their nodes, here 3e-8 and
// less at 24 nodes (a bubble's 2e-6).
TEST(BoundedSecondOrder, EqualsTheSolversWhereModesSuffice) {
  const std::string forward = henyey_greenstein(0.5), back = henyey_greenstein(-0.3);
  const Case cases[] = {
      {"coat", smooth(1.5) + layer(kSphere, 0.9, kInfinity)},
      {"glass", smooth(1.5) + layer(forward, 0.9, 1.2) + smooth(1)},
      {"two media", smooth(1.5) + layer(forward, 0.9, 0.7) + smooth(1.2) + layer(kSphere, 1, 0.4)},
      {"bubble", layer(kSphere, 0.9, 0.5) + smooth(0.8) + layer(back, 0.9, 0.6)},
      {"rare between", smooth(1.5) + layer(forward, 0.9, 0.3) + smooth(1.1) +
                           layer(forward, 0, 0.1) + smooth(1.5) + layer(kSphere, 0.8, 0.5)},
      {"dense between", layer(forward, 0.9, 0.3) + smooth(1.7) + layer(back, 0, 0.1) + smooth(1) +
                            layer(kSphere, 0.8, 0.5)},
      {"black ground",
       smooth(1.5) + layer(forward, 0.9, 0.5) + layer(kSphere, 0.6, 0.2) + lambert_ground(0)}};
  for (const Case& c : cases) {
    const Stack stack = stack_of(c.toml);
    const DeterministicSolution s = solve_deterministic(
        stack, {.tolerance = 1e-10, .min_nodes = 16, .max_nodes = 24, .max_seconds = 1e4});
    const double allowed = s.accuracy().node_error;
    EXPECT_LT(allowed, 1e-5) << c.name;
    const SecondOrder second(stack, 0);
    std::vector<double> mu_i{0.6, 0.02}, mu_o{0.05, 0.6, 0.95};
    if (stack.is_open_below()) {
      mu_i.insert(mu_i.end(), {-0.3, -0.9});
      mu_o.insert(mu_o.end(), {-0.05, -0.7});
    }
    const DeterministicField field = s.field(mu_i, mu_o);
    for (std::size_t i = 0; i < mu_i.size(); ++i)
      for (std::size_t o = 0; o < mu_o.size(); ++o)
        for (const double x : {0.0, 1.1}) {
          const double expected = field.multiple(i, o, x).order[1].r;
          const SecondOrder::Value value =
              second(along(mu_i[i], 0), along(mu_o[o], kPi - x), 1e-10 * expected);
          EXPECT_NEAR(value.f, expected, (allowed + 1e-7) * expected)
              << c.name << ' ' << mu_i[i] << ' ' << mu_o[o] << ' ' << x;
        }
  }
}

TEST(BoundedSecondOrder, OfMirrorFlakesIsTheSumOfItsModes) {
  for (const std::string& medium :
       {sggx(0.5, "mirror"), vmf(0.5, "mirror"), sggx(0.5, "mirror") + "\nf0 = 0.04"}) {
    const SecondOrder second(
        stack_of(smooth(1.5) + layer(medium, 0.9, 1.5) + smooth(1.2) + layer(kSphere, 0.7, 0.3)),
        0);
    const double pairs[][2] = {{0.6, 0.45}, {0.17, 0.03}, {-0.3, 0.9}, {0.6, -0.6}, {0.6, -0.85}};
    for (const auto& [mu_i, mu_o] : pairs) {
      const SecondOrder::Modes fine = second.modes(mu_i, mu_o, 96, 1e-11);
      const ModeTail tail = fit_mode_tail({fine.f.data(), 96});
      for (const double x : {0.05, 0.7}) {
        double sum = tail.sum(x);
        for (int m = 0; m < 96; ++m) sum += (m == 0 ? 1 : 2) * fine.f[m] * std::cos(m * x);
        const SecondOrder::Value value = second(along(mu_i, 0), along(mu_o, kPi - x), 1e-12);
        EXPECT_NEAR(sum / value.f, 1, 2e-8 + (tail.error + value.error) / value.f)
            << medium << ' ' << mu_i << ' ' << mu_o << ' ' << x;
      }
    }
  }
}

// The whole, with orders 3 and up and events of Lambertian flakes in modes, straight through a
// plate and beside the straight way, where sums of modes end at 1e-3.
TEST(BoundedSecondOrder, GivesPairsTheDigitsThatModesDoNotHave) {
  const Stack stack = stack_of(smooth(1.5) + layer(sggx(0.5, "mirror"), 0.9, 1) +
                               layer(sggx(0.5, "lambert"), 0.8, 0.3) + smooth(1));
  const auto solve = [&](int nodes) {
    return solve_deterministic(stack, {.tolerance = 1e-6,
                                       .min_nodes = nodes / 3 * 2,
                                       .max_nodes = nodes,
                                       .max_modes = 64,
                                       .max_seconds = 1e4});
  };
  const DeterministicSolution coarse = solve(18), fine = solve(36);
  const double pairs[][3] = {{0.6, -0.6, 0}, {0.6, -0.59, 0.01}, {0.2, 0.05, 0}};
  int exact = 0;
  for (const auto& [mu_i, mu_o, x] : pairs) {
    const DeterministicValue a = coarse.f(along(mu_i, 0), along(mu_o, kPi - x)),
                             b = fine.f(along(mu_i, 0), along(mu_o, kPi - x));
    exact += a.exact_second && b.exact_second;
    const double all = b.order[Order::all].r;
    EXPECT_NEAR(a.order[Order::all].r, all, a.error.r + b.error.r) << mu_i << ' ' << mu_o;
    EXPECT_LT(a.error.r, 1e-3 * all) << mu_i << ' ' << mu_o;
    EXPECT_LT(b.error.r, 1e-6 * all) << mu_i << ' ' << mu_o;
  }
  EXPECT_GE(exact, 2);
}

TEST(BoundedSecondOrder, IsReciprocal) {
  const double below = 1.2;
  const SecondOrder second(stack_of(smooth(1.5) + layer(sggx(0.3, "mirror"), 0.9, 1.5) +
                                    layer(vmf(0.4, "mirror"), 0.9, 0) + smooth(below)),
                           0);
  const double pairs[][3] = {
      {0.01, 0.012, 0}, {0.6, 0.05, 0.01}, {0.6, -0.5, 0.3}, {-0.4, -0.9, 1}};
  for (const auto& [mu_i, mu_o, x] : pairs) {
    const Direction a = along(mu_i, 0), b = along(mu_o, kPi - x);
    const auto squared = [&](double mu) { return mu < 0 ? below * below : 1.0; };
    const double forth = second(a, b, 1e-11).f / squared(mu_o);
    EXPECT_NEAR(second(b, a, 1e-11).f / squared(mu_i) / forth, 1, 1e-8) << mu_i << ' ' << mu_o;
  }
}

// Between boundaries that are as good as none it is that of the layers alone.
TEST(BoundedSecondOrder, GoesOverIntoThatOfLayers) {
  const std::string layers =
      layer(sggx(0.4, "mirror"), 0.9, 0.8) + layer(vmf(0.5, "mirror"), 0.8, 0.5);
  const SecondOrder open(stack_of(layers), 0),
      bounded(stack_of(smooth(1 + 1e-9) + layers + smooth(1)), 0);
  const double pairs[][3] = {{0.6, 0.45, 0.3}, {-0.3, 0.9, 1}, {0.2, -0.7, 2}, {-0.5, -0.6, 0}};
  for (const auto& [mu_i, mu_o, x] : pairs) {
    const Direction a = along(mu_i, 0), b = along(mu_o, kPi - x);
    const double expected = open(a, b, 1e-11).f;
    // Next to grazing all light is reflected, within angles of 5e-5.
    EXPECT_NEAR(bounded(a, b, 1e-11).f / expected, 1, 1e-7) << mu_i << ' ' << mu_o;
  }
}

}  // namespace
}  // namespace lamella
