// Next-event walks whose first flights do not leave (volume/lanes/lane_forced_flights.h), on every
// instruction set of the machine.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/volume/lanes/lane_agreement.h"
#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_setting.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::expect_same_lobes;
using testing::lane_isas;
using testing::layer;
using testing::stack_from;
using testing::z_between;

struct ForcedCase {
  const char* what;
  std::string toml;
  double theta;
};

const std::string kSpheres = "medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = ";

const std::vector<ForcedCase>& forced_cases() {
  static const std::vector<ForcedCase> list{
      {"a half space", layer(kSpheres + "inf"), 60},
      {"a thin slab", layer(kSpheres + "0.2"), 20},
      {"a deep slab", layer(kSpheres + "40"), 0},
      {"grazing light", layer(kSpheres + "1"), 89},
      {"a narrow peak, white",
       layer("medium = 'henyey_greenstein'\ng = 0.9\nalbedo = 1\nthickness = 1"), 40},
      {"mirrors", layer("medium = 'sggx'\nroughness = 0.4\nalbedo = 0.9\nthickness = 2"), 70},
      {"leaning flakes from below",
       layer("medium = 'sggx'\nflake = 'lambert'\nroughness = 0.4\naxis = [0.5, 0, 1]\n"
             "albedo = 0.8\nthickness = 1"),
       125},
      {"one-sided flakes, leaning",
       layer("medium = 'vmf_flake'\nroughness = 0.5\naxis = [0.5, 0, 1]\nflake = 'mirror'\n"
             "albedo = 0.9\nthickness = 1"),
       30},
      {"narrow flakes, leaning",
       layer("medium = 'vmf_flake'\nroughness = 0.2\naxis = [0.5, 0, 1]\nflake = 'mirror'\n"
             "albedo = 0.9\nthickness = 1"),
       30},
      {"narrow flakes without an end",
       layer("medium = 'vmf_flake'\nroughness = 0.1\nalbedo = 0.9\nthickness = inf"), 60},
      {"one-sided flakes from behind",
       layer("medium = 'vmf_flake'\nroughness = 0.8\nalbedo = 0.9\nthickness = 1"), 140},
      {"a half space of one-sided flakes",
       layer("medium = 'vmf_flake'\nroughness = 0.3\nalbedo = 0.9\nthickness = inf"), 60},
      {"colour", layer("medium = 'rayleigh'\nalbedo = [0.95, 0.5, 0]\nthickness = 0.7"), 50},
      {"layers of several media",
       layer("medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 0.9\nthickness = 0.3") +
           layer(kSpheres + "0.2") +
           layer("medium = 'sggx'\nroughness = 0.5\nalbedo = 0.9\nthickness = 1"),
       60},
      {"layers from below",
       layer(kSpheres + "0.7") +
           layer("medium = 'henyey_greenstein'\ng = 0.7\nalbedo = 0.9\nthickness = 0.5"),
       130},
      {"coloured layers, the last without an end",
       layer("medium = 'sggx'\nshape = 'fiber'\nroughness = 0.4\nalbedo = [0.9, 0.6, 0.2]\n"
             "thickness = 0.5") +
           layer("medium = 'lambert_sphere'\nalbedo = [0.9, 0.6, 0.2]\nthickness = inf"),
       30},
      {"black", layer("medium = 'lambert_sphere'\nalbedo = 0\nthickness = 0.7"), 50},
  };
  return list;
}

Plan plan_of(const Stack& stack, Isa isa, Sampling sampling,
             std::optional<std::uint64_t> max_order = {}) {
  Plan plan =
      make_plan(stack, {.max_order = max_order, .thinning = Thinning{0}, .sampling = sampling});
  plan.isa = isa;
  return plan;
}

std::unique_ptr<Simulation> in_cells(const ForcedCase& c, const Plan& plan, std::uint64_t seed) {
  return std::make_unique<Simulation>(stack_from(c.toml), plan, direction_from_degrees(c.theta, 15),
                                      Estimator::next_event, CellGrid{3, 4, false}, seed);
}

class ForcedFlights : public ::testing::TestWithParam<Isa> {};

TEST_P(ForcedFlights, LeaveEnergiesAndCellsAsTheyAre) {
  for (const ForcedCase& c : forced_cases())
    for (const std::optional<std::uint64_t> max_order :
         {std::optional<std::uint64_t>(), std::optional<std::uint64_t>(3)}) {
      const Stack stack = stack_from(c.toml);
      const auto forced = in_cells(c, plan_of(stack, GetParam(), Sampling::rqmc, max_order), 1);
      const auto free = in_cells(c, plan_of(stack, Isa::scalar, Sampling::random, max_order), 2);
      ASSERT_EQ(forced->isa(), GetParam()) << c.what;
      forced->advance(testing::soaked(16384));
      free->advance(testing::soaked(8192));
      const RunResult a = reduce(*forced), b = reduce(*free);
      expect_same_lobes(a, b, c.what);
      // Where nothing absorbs, the ledger has nothing absorbed, whatever roulette does.
      if (stack.layers[0].albedo == Rgb(1)) {
        EXPECT_EQ(a.absorbed[0].value, 0) << c.what;
        EXPECT_LT(std::abs(a.thinned[0].value), allowed_z() * a.thinned[0].standard_error);
      }
      for (int channel = 0; channel < a.channels; ++channel)
        EXPECT_LT(std::abs(z_between(a.unresolved[channel], b.unresolved[channel])), allowed_z())
            << c.what;
    }
}

// Some directions are taken one after the other, many at once.
TEST_P(ForcedFlights, LeavePointsAsTheyAre) {
  for (const ForcedCase& c : forced_cases())
    for (const int count : {2, 40}) {
      const Stack stack = stack_from(c.toml);
      std::vector<Direction> points;
      for (const double sign : {1.0, -1.0})
        for (int j = 0; j < count && (sign > 0 || stack.is_open_below()); ++j)
          points.push_back(direction_from_mu_phi(sign * (j + 0.6) / count, 0.7 + 2.4 * j));
      const auto walks = [&](Isa isa, Sampling sampling, std::uint64_t seed) {
        auto simulation =
            std::make_unique<Simulation>(stack, plan_of(stack, isa, sampling),
                                         direction_from_degrees(c.theta, 15), points, seed);
        simulation->advance(testing::soaked(8192));
        return simulation;
      };
      const auto forced = walks(GetParam(), Sampling::rqmc, 1);
      const auto free = walks(Isa::scalar, Sampling::random, 2);
      const int n = static_cast<int>(points.size());
      for (int j = 0; j < n; ++j)
        for (int o = 0; o <= kTallyOrders; ++o)
          for (int channel = 0; channel < forced->plan().channels; ++channel) {
            const Estimate x = testing::point_estimate(*forced, o, j, n, channel);
            const Estimate y = testing::point_estimate(*free, o, j, n, channel);
            if (x.value < 6 * x.standard_error || y.value < 6 * y.standard_error) continue;
            if (y.value < 1e-9) continue;  // of fixed point nothing
            EXPECT_LT(std::abs(z_between(x, y)), allowed_z())
                << c.what << " point " << j << " order " << o << ' ' << x.value << ' ' << y.value;
          }
    }
}

// Their errors are small enough for the solver to tell a bias of 1e-4 of the light.
TEST_P(ForcedFlights, LeaveEnergiesAsTheSolverHasThem) {
  for (const char* toml : {"medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = inf",
                           "medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = 0.03",
                           "medium = 'henyey_greenstein'\ng = 0.5\nalbedo = 0.9\nthickness = 2"}) {
    const ForcedCase c{toml, layer(toml), 60};
    const Stack stack = stack_from(c.toml);
    const Plan plan = plan_of(stack, GetParam(), Sampling::rqmc);
    const auto walks = in_cells(c, plan, 3);
    walks->advance(testing::soaked(1 << 17));
    const Direction wi[] = {direction_from_degrees(60, 15)};
    const RunResult a = reduce(*walks),
                    b = deterministic_runs(solve_deterministic(stack, {.tolerance = 1e-7}), plan,
                                           wi, CellGrid{3, 4, false}, 1e-6)[0];
    const auto agree = [&](Estimate x, Estimate y, const std::string& which) {
      if (y.value < 1e-7) return;
      EXPECT_LT(std::abs(x.value - y.value),
                allowed_z() * x.standard_error + y.standard_error + 1e-6 * y.value)
          << toml << ' ' << which << ' ' << x.value << ' ' << y.value;
    };
    agree(a.uncollided[0], b.uncollided[0], "uncollided");
    agree(a.absorbed[0], b.absorbed[0], "absorbed");
    for (int o = 0; o < kTallyOrders; ++o) {
      agree(a.reflected.orders[o][0], b.reflected.orders[o][0], "up " + std::to_string(o + 1));
      agree(a.transmitted.orders[o][0], b.transmitted.orders[o][0],
            "down " + std::to_string(o + 1));
    }
  }
}

TEST_P(ForcedFlights, AreTheSameHoweverTheyAreDealtOut) {
  for (const char* albedo : {"0.9", "[0.9, 0.5, 0.2]"}) {
    const ForcedCase c{
        albedo,
        layer(std::string("medium = 'sggx'\nroughness = 0.5\nthickness = 1\nalbedo = ") + albedo),
        40};
    const Stack stack = stack_from(c.toml);
    const Plan plan = plan_of(stack, GetParam(), Sampling::rqmc);
    const auto whole = in_cells(c, plan, 7), parts = in_cells(c, plan, 7);
    whole->advance(20000);
    for (const std::uint64_t walks : {1000, 1001, 9000}) parts->advance(walks);
    const auto restored = in_cells(c, plan, 7);
    for (int k = 0; k < kBatches; ++k)
      restored->restore(k, parts->batches()[k], parts->lane_counts(k));
    restored->restore_walks(parts->walks());
    for (Simulation* simulation : {parts.get(), restored.get()}) {
      simulation->advance(20000);
      for (int k = 0; k < kBatches; ++k) {
        const BatchTally &a = whole->batches()[k], &b = simulation->batches()[k];
        EXPECT_EQ(a.f, b.f) << albedo;
        EXPECT_EQ(a.energy.up, b.energy.up) << albedo;
        EXPECT_EQ(a.energy.down, b.energy.down) << albedo;
        EXPECT_EQ(a.energy.absorbed, b.energy.absorbed) << albedo;
        EXPECT_EQ(a.collisions, b.collisions) << albedo;
      }
    }
  }
}

// What they are for. `lamella bench --only sampling` measures how much more it is.
TEST_P(ForcedFlights, MakeOrdersSmoothForLattices) {
  const ForcedCase c{"mirrors",
                     layer("medium = 'sggx'\nroughness = 0.5\nalbedo = 0.9\nthickness = 2"), 60};
  const Stack stack = stack_from(c.toml);
  const auto variance = [&](Sampling sampling, int order) {
    const auto walks = in_cells(c, plan_of(stack, GetParam(), sampling), 5);
    walks->advance(1 << 17);
    double sum = 0;
    for (const double error : reduce(*walks).reflected.lobes[order].standard_error)
      sum += error * error;
    return sum;
  };
  for (const Order order : {Order::two, Order::three})
    EXPECT_GT(variance(Sampling::random, place(order)), 4 * variance(Sampling::rqmc, place(order)));
}

INSTANTIATE_TEST_SUITE_P(Isas, ForcedFlights, ::testing::ValuesIn(lane_isas()),
                         [](const auto& test) { return to_text(test.param); });

}  // namespace
}  // namespace lamella
