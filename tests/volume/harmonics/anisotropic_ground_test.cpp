// Grounds and interfaces that tell x from y, beside tilted layers: Lambert's law in the place of a
// ground that is said to differ, turns of stack and light by one azimuth, reciprocity, and walks,
// order by order.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "phase/math/sampling.h"
#include "phase/surface/surface_law.h"
#include "tests/statistics/statistics.h"
#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/harmonics/harmonic_pairs.h"
#include "volume/harmonics/harmonic_run.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

// f = (a + b (u . w_i)^2 (u . w_o)^2) / pi, u in the plane: reciprocal, with four waves in the
// azimuth, and the same at -x and -y only where u lies along one of them.
class RidgedLaw : public SurfaceLaw {
 public:
  RidgedLaw(double a, double b, double turn)
      : a_(a), b_(b), u_{std::cos(turn), std::sin(turn), 0} {}
  [[nodiscard]] Rgb eval(Direction wi, Direction wo, RandomStream&) const override {
    const double i = dot(u_, wi), o = dot(u_, wo);
    return Rgb((a_ + b_ * i * i * o * o) / kPi);
  }
  [[nodiscard]] std::optional<Sample> sample(Direction wi, RandomStream& stream) const override {
    const double u1 = stream.uniform(), u2 = stream.uniform();
    const Direction wo = direction_from_mu_phi(std::sqrt(u1), 2 * kPi * u2);
    return Sample{wo, kPi * eval(wi, wo, stream)};
  }
  [[nodiscard]] bool is_symmetric_about_z() const override { return false; }

 private:
  double a_, b_;
  Direction u_;
};

std::string tilted_flakes(double turn) {
  return layer(
      fmt::format("{}\naxis = [{}, {}, 0.4]", sggx(0.7, "lambert"), std::cos(turn), std::sin(turn)),
      0.9, 0.7);
}
const std::string kFilm = "[[layer]]\ninterface = \"smooth\"\nior = 1.5\n";

Stack over_law(const std::string& toml, double a, double b, double turn) {
  Stack stack = stack_of(toml);
  stack.substrate = Substrate{.model = "ridged", .law = std::make_shared<RidgedLaw>(a, b, turn)};
  return stack;
}

RunResult run_of(const Stack& stack, Direction wi, CellGrid grid, double tolerance,
                 int max_degree) {
  const Direction incident[] = {wi};
  return harmonic_runs(
      stack, make_plan(stack), incident, grid,
      {.tolerance = tolerance, .max_seconds = kInfinity, .max_degree = max_degree})[0];
}

double f_at(const Stack& stack, Direction wi, Direction wo, int degree) {
  const std::pair<Direction, Direction> pairs[] = {{wi, wo}};
  DeterministicAccuracy accuracy;
  return harmonic_pairs(stack, pairs,
                        {.tolerance = 1e-9, .max_seconds = kInfinity, .max_degree = degree},
                        accuracy)[0]
      .f.r;
}

Direction turned_about_z(Direction w, double turn) {
  return direction_from_mu_phi(w.z, azimuth(w) + turn);
}

void expect_same(const RunResult& a, const RunResult& b, double near) {
  EXPECT_NEAR(a.absorbed[0].value, b.absorbed[0].value, near);
  EXPECT_NEAR(a.lost[0].value, b.lost[0].value, near);
  for (int o = 0; o < kTallyOrders; ++o)
    EXPECT_NEAR(a.reflected.orders[o][0].value, b.reflected.orders[o][0].value, near) << o;
  for (const Order order : {Order::one, Order::two, Order::three, Order::all}) {
    const LobeEstimate &x = a.reflected.lobes[order], &y = b.reflected.lobes[order];
    ASSERT_EQ(x.value.size(), y.value.size());
    for (std::size_t k = 0; k < x.value.size(); ++k)
      EXPECT_NEAR(x.value[k], y.value[k], near) << to_text(order) << " cell " << k;
  }
}

// The solver of open stacks has Lambert's ground by another way; no wave meets another in it.
TEST(AnisotropicGround, IsLambertsWhereItSendsAsMuchEverywhere) {
  const Direction wi = direction_from_mu_phi(0.7, 0.5);
  const RunResult open =
      run_of(stack_of(tilted_flakes(0.2) + lambert_ground(0.5)), wi, {3, 6}, 1e-6, 34);
  const RunResult wave = run_of(over_law(tilted_flakes(0.2), 0.5, 0, 0), wi, {3, 6}, 1e-6, 24);
  expect_same(wave, open, 1e-6);
}

TEST(AnisotropicGround, TurnsWithTheStack) {
  const Direction wi = direction_from_mu_phi(0.6, 0.3);
  for (const std::string& face : {std::string(), kFilm}) {
    const RunResult here =
        run_of(over_law(face + tilted_flakes(0.2), 0.3, 0.6, 0.9), wi, {3, 6}, 1e-6, 12);
    const RunResult there = run_of(over_law(face + tilted_flakes(1.3), 0.3, 0.6, 2.0),
                                   turned_about_z(wi, 1.1), {3, 6}, 1e-6, 12);
    expect_same(here, there, 1e-6);
    EXPECT_NEAR(ledger_sum(here, 0), 1, 1e-6);
  }
}

TEST(AnisotropicGround, IsReciprocalBelowTiltedAndSymmetricLayers) {
  const Direction a = direction_from_mu_phi(0.8, 0.3), b = direction_from_mu_phi(0.35, 2);
  for (const std::string& toml :
       {tilted_flakes(0.2), kFilm + tilted_flakes(0.2), layer(kIsotropic, 0.9, 0.7),
        kFilm + tilted_flakes(0.2) + "[[layer]]\ninterface = \"smooth\"\nior = 1.2\n" +
            layer(kIsotropic, 0.9, 0.7)}) {
    const Stack stack = over_law(toml, 0.3, 0.6, 0.9);
    EXPECT_NEAR(f_at(stack, a, b, 12) / f_at(stack, b, a, 12), 1, 1e-5) << toml;
  }
}

// Energies and cells by order: z of walks has a root mean square near 1.
TEST(AnisotropicGround, AgreesWithWalksOrderByOrder) {
  for (const std::string& toml :
       {tilted_flakes(0.2), layer(kIsotropic, 0.9, 0.7), kFilm + tilted_flakes(0.2)}) {
    const Stack stack = over_law(toml, 0.2, 0.75, 0.9);
    const Direction wi = direction_from_mu_phi(0.5, 0.5);
    const CellGrid grid{2, 4};
    const RunResult exact = run_of(stack, wi, grid, 1e-4, 17);
    EXPECT_LT(exact.accuracy->error, 1e-3) << toml;
    Simulation walks(stack, make_plan(stack), wi, Estimator::analog, grid, 5);
    walks.advance(is_soak() ? 30000000 : 300000);
    const RunResult found = reduce(walks);
    const double limit = testing::normal_quantile(testing::test_level() / 200);
    double squares = 0;
    int count = 0;
    const auto agree = [&](const Estimate& a, const Estimate& b, const std::string& what) {
      if (!(b.standard_error > 0)) return;
      const double z = (a.value - b.value) / std::hypot(a.standard_error, b.standard_error);
      EXPECT_LT(std::abs(z), limit) << what << ' ' << a.value << ' ' << b.value << '\n' << toml;
      squares += z * z;
      ++count;
    };
    agree(exact.absorbed[0], found.absorbed[0], "absorbed");
    for (int o = 0; o < kTallyOrders; ++o)
      agree(exact.reflected.orders[o][0], found.reflected.orders[o][0], fmt::format("slot {}", o));
    for (const Order order : {Order::one, Order::two, Order::three, Order::multiple})
      for (std::size_t k = 0; k < found.reflected.lobes[order].value.size(); ++k) {
        const LobeEstimate &x = exact.reflected.lobes[order], &y = found.reflected.lobes[order];
        agree({x.value[k], x.standard_error[k]}, {y.value[k], y.standard_error[k]},
              "cell of order " + to_text(order));
      }
    EXPECT_NEAR(std::sqrt(squares / count), 1, 0.4) << toml;
  }
}

// Facets that differ along x and y: a quarter turn of all else is their exchange.
TEST(AnisotropicFacets, AreReciprocalAndTurnWithTheStack) {
  const auto face = [](double x, double y) {
    return fmt::format("[[layer]]\ninterface = \"ggx\"\nior = 1.5\nroughness = [{}, {}]\n", x, y);
  };
  const auto conductor = [](double x, double y) {
    return fmt::format(
        "[substrate]\nbsdf = \"conductor\"\neta = 0.2\nk = 3\ndistribution = \"ggx\"\n"
        "roughness = [{}, {}]\n",
        x, y);
  };
  const Direction a = direction_from_mu_phi(0.8, 0.3), b = direction_from_mu_phi(0.5, 2);
  for (const bool is_ground : {true, false}) {
    const auto stack = [&](double x, double y, double turn) {
      return stack_of(is_ground ? tilted_flakes(turn) + conductor(x, y)
                                : face(x, y) + tilted_flakes(turn));
    };
    const Stack here = stack(0.6, 0.45, 0.2);
    const double forth = f_at(here, a, b, 17), back = f_at(here, b, a, 17);
    EXPECT_NEAR(forth / back, 1, is_ground ? 1e-4 : 1e-3);
    const Stack there = stack(0.45, 0.6, 0.2 + kPi / 2);
    EXPECT_NEAR(f_at(there, turned_about_z(a, kPi / 2), turned_about_z(b, kPi / 2), 17) / forth, 1,
                1e-8);
  }
}

}  // namespace
}  // namespace lamella
