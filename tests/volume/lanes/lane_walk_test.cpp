// Walks on lanes, on every instruction set of the machine, against the scalar double kernel and
// against what is known.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <memory>
#include <numeric>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_run.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::lane_isas;
using testing::layer;
using testing::point_estimate;
using testing::stack_from;
using testing::z_between;

Plan plan_for(const Stack& stack, Isa isa, std::uint64_t max_order = 1000) {
  Plan plan = make_plan(stack, {.max_order = max_order});
  plan.isa = isa;
  return plan;
}

struct Case {
  std::string keys;
  Direction wi;
};

// Every kernel, from above and below, straight, oblique and grazing, symmetric or not.
const std::vector<Case>& cases() {
  static const std::vector<Case> list{
      {"medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = inf", direction_from_degrees(60, 40)},
      {"medium = 'lambert_sphere'\nalbedo = 0.7\nthickness = 0.3", direction_from_degrees(89, 0)},
      {"medium = 'henyey_greenstein'\ng = 0.7\nalbedo = 0.95\nthickness = 4",
       direction_from_degrees(0, 0)},
      {"medium = 'henyey_greenstein'\ng = -0.4\nalbedo = 0.99\nthickness = 2",
       direction_from_degrees(130, 10)},
      {"medium = 'sggx'\nroughness = 0.5\nalbedo = 0.9\nthickness = 2",
       direction_from_degrees(60, 200)},
      {"medium = 'sggx'\nshape = 'fiber'\nroughness = 0.3\naxis = [1, 0.4, 0.3]\nalbedo = 0.8\n"
       "thickness = 1",
       direction_from_degrees(110, 70)},
      {"medium = 'sggx'\nroughness = 0.4\nflake = 'lambert'\nalbedo = 0.9\nthickness = 3",
       direction_from_degrees(30, 0)},
      {"medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 0.9\nthickness = inf",
       direction_from_degrees(60, 0)},
      {"medium = 'vmf_flake'\nroughness = 0.05\nalbedo = 0.9\nthickness = 2",
       direction_from_degrees(20, 0)},
      {"medium = 'vmf_flake'\nroughness = 0.6\nflake = 'mirror'\nalbedo = 0.9\nthickness = 1.5",
       direction_from_degrees(150, 0)},
      {"medium = 'vmf_flake'\nalpha = 0.02\nalbedo = 0.9\nthickness = 2",
       direction_from_degrees(75, 0)},
      {"medium = 'vmf_flake'\nalpha = 0.1\nflake = 'mirror'\nalbedo = 0.9\nthickness = 1.5",
       direction_from_degrees(70, 0)},
      {"medium = 'vmf_flake'\nroughness = 0.5\naxis = [0.5, 0.2, 1]\nalbedo = 0.9\nthickness = 2",
       direction_from_degrees(50, 200)},
      {"medium = 'vmf_flake'\nalpha = 0.5\nflake = 'mirror'\naxis = [1, 0, -0.2]\nalbedo = 0.9\n"
       "thickness = 3",
       direction_from_degrees(60, 100)},
      {"medium = 'vmf_flake'\nalpha = 0.003\naxis = [0.2, 0, 1]\nalbedo = 0.9\nthickness = 2",
       direction_from_degrees(60, 0)},
      {"medium = 'vmf_flake'\nalpha = 0.8\naxis = [-0.7, 0, 1]\nalbedo = 0.95\nthickness = inf",
       direction_from_degrees(70, 0)},
      {"medium = 'vmf_flake'\nalpha = inf\nalbedo = 0.8\nthickness = 4",
       direction_from_degrees(45, 0)},
  };
  return list;
}

constexpr std::uint64_t kLaneWalks = 60000;

std::unique_ptr<Simulation> on_cells(const Case& c, Isa isa, std::uint64_t seed) {
  const Stack stack = stack_from(layer(c.keys));
  auto simulation = std::make_unique<Simulation>(stack, plan_for(stack, isa), c.wi,
                                                 Estimator::analog, CellGrid{3, 4, false}, seed);
  simulation->advance(testing::soaked(kLaneWalks));
  return simulation;
}

std::vector<Direction> some_points(int count, bool below) {
  std::vector<Direction> points;
  for (const double sign : {1.0, -1.0})
    for (int j = 0; j < count && (sign > 0 || below); ++j)
      points.push_back(direction_from_mu_phi(sign * (j + 0.6) / count, 0.7 + 2.4 * j));
  return points;
}

std::unique_ptr<Simulation> on_points(const Case& c, Isa isa, std::uint64_t seed, int count,
                                      std::uint64_t walks = kLaneWalks / 4) {
  const Stack stack = stack_from(layer(c.keys));
  auto simulation = std::make_unique<Simulation>(stack, plan_for(stack, isa), c.wi,
                                                 some_points(count, stack.is_open_below()), seed);
  simulation->advance(testing::soaked(walks));
  return simulation;
}

const Simulation& scalar_cells(std::size_t k) {
  static std::vector<std::unique_ptr<Simulation>> done(cases().size());
  if (!done[k]) done[k] = on_cells(cases()[k], Isa::scalar, 2);
  return *done[k];
}

class LaneWalk : public ::testing::TestWithParam<Isa> {};

TEST_P(LaneWalk, EnergiesAndCellsAgreeWithTheScalarKernel) {
  for (std::size_t k = 0; k < cases().size(); ++k) {
    const std::string& what = cases()[k].keys;
    const auto lanes = on_cells(cases()[k], GetParam(), 1);
    ASSERT_EQ(lanes->isa(), GetParam()) << what;
    EXPECT_GT(lanes->lane_use()->occupancy, 0.3) << what;
    const RunResult a = reduce(*lanes), b = reduce(scalar_cells(k));
    EXPECT_NEAR(ledger_sum(a, 0), 1, 1e-12) << what;
    const auto agree = [&](Estimate x, Estimate y, const char* which) {
      // Too few walks for a normal error on either side: none to compare.
      if (x.value * kLaneWalks < 30 || y.value * kLaneWalks < 30) return;
      EXPECT_LT(std::abs(z_between(x, y)), allowed_z())
          << what << ' ' << which << ' ' << x.value << ' ' << y.value;
    };
    agree(a.uncollided[0], b.uncollided[0], "uncollided");
    agree(a.absorbed[0], b.absorbed[0], "absorbed");
    const double mean_events = static_cast<double>(a.collisions) / static_cast<double>(a.walks);
    EXPECT_NEAR(mean_events, static_cast<double>(b.collisions) / static_cast<double>(b.walks),
                0.05 * mean_events)
        << what;
    for (const bool reflected : {true, false}) {
      const SideResult& x = reflected ? a.reflected : a.transmitted;
      const SideResult& y = reflected ? b.reflected : b.transmitted;
      for (int o = 0; o < kTallyOrders; ++o) {
        agree(x.orders[o][0], y.orders[o][0], reflected ? "reflected" : "transmitted");
        ASSERT_EQ(x.lobes[o].value.size(), y.lobes[o].value.size());
        for (std::size_t j = 0; j < x.lobes[o].value.size(); ++j)
          agree({x.lobes[o].value[j], x.lobes[o].standard_error[j]},
                {y.lobes[o].value[j], y.lobes[o].standard_error[j]},
                reflected ? "reflected cell" : "transmitted cell");
      }
    }
  }
}

TEST_P(LaneWalk, PointsAgreeWithTheScalarKernel) {
  for (const std::size_t k : {0, 2, 4, 5, 6, 7, 8}) {
    for (const int count : {1, 9, 33}) {  // one direction after the other, and many at once
      const auto lanes = on_points(cases()[k], GetParam(), 1, count);
      const auto scalar = on_points(cases()[k], Isa::scalar, 2, count);
      ASSERT_EQ(lanes->isa(), GetParam());
      const int points = static_cast<int>(lanes->batches()[0].f.size()) / kTallyOrders;
      for (int j = 0; j < points; ++j)
        for (int o = 0; o <= kTallyOrders; ++o) {
          const Estimate x = point_estimate(*lanes, o, j, points);
          const Estimate y = point_estimate(*scalar, o, j, points);
          EXPECT_LT(std::abs(z_between(x, y)), allowed_z())
              << cases()[k].keys << " point " << j << " order " << o << ' ' << x.value << ' '
              << y.value;
        }
    }
  }
}

std::vector<double> all_sums(const Simulation& simulation) {
  std::vector<double> sums;
  for (const BatchTally& b : simulation.batches()) {
    sums.insert(sums.end(), b.f.begin(), b.f.end());
    for (const auto& order : b.energy.up) sums.insert(sums.end(), order.begin(), order.end());
    sums.insert(sums.end(), b.energy.absorbed.begin(), b.energy.absorbed.end());
    sums.push_back(static_cast<double>(b.collisions));
  }
  return sums;
}

TEST_P(LaneWalk, IsBitIdenticalForAnyThreadsAndCheckpoints) {
  for (const std::size_t k : {0, 4, 7})
    for (const int count : {0, 1, 9, 33}) {
      const auto sums = [&](int threads, const std::vector<std::uint64_t>& checkpoints) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        tbb::task_arena arena(threads);
        return arena.execute([&] {
          const Stack stack = stack_from(layer(cases()[k].keys));
          const Plan plan = plan_for(stack, GetParam());
          const auto simulation =
              count ? std::make_unique<Simulation>(stack, plan, cases()[k].wi,
                                                   some_points(count, false), 7)
                    : std::make_unique<Simulation>(stack, plan, cases()[k].wi, Estimator::analog,
                                                   CellGrid{4, 8, false}, 7);
          for (const std::uint64_t walks : checkpoints) simulation->advance(walks);
          return all_sums(*simulation);
        });
      };
      const auto one = sums(1, {9000});
      EXPECT_EQ(one, sums(2, {9000}));
      EXPECT_EQ(one, sums(7, {1, 130, 131, 2048, 8999, 9000}));
    }
}

TEST_P(LaneWalk, AbsorbedWalksAreTheRest) {
  // Where roulette surely ends a walk before max_order does, what it ends is not counted one by
  // one. At albedo 0.9 that is from max_order = 216 on; beyond 210 events come 4e-10 of the walks.
  for (const char* albedo : {"0.9", "[0.9, 0.5, 0.1]"})
    for (const bool cells : {false, true}) {
      const Stack stack = stack_from(layer(
          "medium = 'henyey_greenstein'\ng = 0.7\nthickness = 9\nalbedo = " + std::string(albedo)));
      std::vector<std::vector<double>> sums;
      for (const std::uint64_t max_order : {210, 1000}) {
        const Plan plan = plan_for(stack, GetParam(), max_order);
        const Direction wi = direction_from_degrees(60, 0);
        EXPECT_EQ(LaneSetting<float>(stack, plan, wi, 3).walk.ends_absorb, max_order == 1000);
        const auto s =
            cells ? std::make_unique<Simulation>(stack, plan, wi, Estimator::analog,
                                                 CellGrid{4, 8, false}, 3)
                  : std::make_unique<Simulation>(stack, plan, wi, std::vector<Direction>{}, 3);
        s->advance(50000);
        EXPECT_GT(s->batches()[0].energy.absorbed[0], 50000 / 128 / 4);
        sums.push_back(all_sums(*s));
      }
      EXPECT_EQ(sums[0], sums[1]) << albedo << (cells ? ", cells" : "");
    }
}

TEST_P(LaneWalk, TheSameWalksOnAnotherInstructionSetDifferByRoundingOnly) {
  // Same numbers, other rounding (fused or not, other reciprocals): now and then a walk takes
  // another turn. 3e-4 is 18 of the 60000 walks.
  for (std::size_t k = 0; k < cases().size(); ++k) {
    const RunResult a = reduce(*on_cells(cases()[k], GetParam(), 1));
    const RunResult b = reduce(*on_cells(cases()[k], Isa::sse4, 1));
    EXPECT_NEAR(a.reflected.total[0].value, b.reflected.total[0].value, 3e-4) << cases()[k].keys;
    EXPECT_NEAR(a.absorbed[0].value, b.absorbed[0].value, 3e-4) << cases()[k].keys;
  }
}

TEST_P(LaneWalk, IsotropicSlabMatchesVanDeHulst1980Table12) {
  const Stack stack = load_stack("isotropic_slab");
  const double mu[] = {1, 0.7, 0.3, 0.1};
  const double reflected[] = {0.28616, 0.34188, 0.45353, 0.53214};
  const double transmitted[] = {0.14864, 0.13963, 0.09425, 0.06601};
  for (int k = 0; k < 4; ++k) {
    Simulation s(stack, plan_for(stack, GetParam()), direction_from_mu_phi(mu[k], 0),
                 {direction_from_mu_phi(0.5, 1), direction_from_mu_phi(-0.5, 1)}, 1);
    s.advance(testing::soaked(200000));
    const Estimate r = point_estimate(s, kTallyOrders, 0, 2);
    const Estimate t = point_estimate(s, kTallyOrders, 1, 2);
    EXPECT_NEAR(kPi * r.value, reflected[k], allowed_z() * kPi * r.standard_error + 5e-6);
    EXPECT_NEAR(kPi * t.value, transmitted[k], allowed_z() * kPi * t.standard_error + 5e-6);
  }
}

TEST_P(LaneWalk, ThinLayersForceTheirFirstCollision) {
  // Order 1 of an isotropic layer tends to c depth / (2 mu): half of what collides. The next terms
  // are depth log(depth) smaller.
  for (const double depth : {1e-9, 1e-5}) {
    const Stack stack =
        stack_from(layer("medium = 'henyey_greenstein'\nalbedo = 0.8\nthickness = " +
                         std::to_string(depth * 1e9) + "e-9"));
    Simulation s(stack, plan_for(stack, GetParam()), direction_from_mu_phi(0.5, 0),
                 Estimator::analog, CellGrid{2, 2, false}, 1);
    s.advance(20000);
    const RunResult run = reduce(s);
    const Estimate up = run.reflected.orders[0][0];
    EXPECT_NEAR(up.value / depth, 0.8, allowed_z() * up.standard_error / depth + 20 * depth);
    EXPECT_LT(up.standard_error, 0.01 * up.value);
    EXPECT_NEAR(run.uncollided[0].value, std::exp(-2 * depth), 1e-12);
    EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-12);
  }
}

TEST_P(LaneWalk, HardCasesKeepTheLedgerOrAreLeftToDouble) {
  const char* media[] = {"medium = 'sggx'\nroughness = 0.02",
                         "medium = 'sggx'\nroughness = 1",
                         "medium = 'sggx'\nroughness = 0.03\nflake = 'lambert'",
                         "medium = 'vmf_flake'\nroughness = 1",
                         "medium = 'vmf_flake'\nalpha = 0.2",
                         "medium = 'vmf_flake'\nalpha = 0.01",
                         "medium = 'vmf_flake'\nalpha = 0.01\nflake = 'mirror'",
                         "medium = 'vmf_flake'\nalpha = inf\nflake = 'mirror'",
                         "medium = 'vmf_flake'\nroughness = 0.1\naxis = [0, 0, -1]",
                         "medium = 'vmf_flake'\nroughness = 0.5\naxis = [0.5, 0, 1]",
                         "medium = 'vmf_flake'\nalpha = 0.001\naxis = [1, 0, 0]",
                         "medium = 'vmf_flake'\nalpha = 0.001\nflake = 'mirror'",
                         "medium = 'lambert_sphere'",
                         "medium = 'henyey_greenstein'\ng = 0.97",
                         "medium = 'henyey_greenstein'\ng = -0.97"};
  for (const char* medium : media)
    for (const char* thickness : {"1e-9", "1", "1e4", "inf"})
      for (const char* albedo : {"0", "0.9", "1"})
        for (const double mu : {1.0, 1e-3, 0.0, -1e-7, -1.0}) {
          if (mu < 0 && std::string(thickness) == "inf") continue;
          const std::string keys =
              std::string(medium) + "\nthickness = " + thickness + "\nalbedo = " + albedo;
          const Stack stack = stack_from(layer(keys));
          Simulation s(stack, plan_for(stack, GetParam(), 200), direction_from_mu_phi(mu, 0.3),
                       Estimator::analog, CellGrid{2, 4, false}, 1);
          ASSERT_EQ(s.isa(), GetParam()) << keys;
          s.advance(512);
          const RunResult run = reduce(s);
          EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-12) << keys << " mu " << mu;
          if (std::string(albedo) == "0") {
            EXPECT_EQ(run.reflected.total[0].value, 0) << keys;
          }
        }
  for (const char* medium : {"medium = 'sggx'\nroughness = 0.001\nthickness = 1",
                             "medium = 'vmf_flake'\nalpha = 0.0005\nthickness = 1",
                             "medium = 'henyey_greenstein'\ng = 0.99\nthickness = 1",
                             "medium = 'lambert_sphere'\nthickness = 1e9"}) {
    const Stack stack = stack_from(layer(medium));
    EXPECT_TRUE(why_not_lanes(stack, plan_for(stack, GetParam()))) << medium;
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, LaneWalk, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LaneWalk);

TEST(LaneWalk, EveryWalkHasAnEnd) {
  const Stack stack =
      stack_from(layer("medium = 'henyey_greenstein'\nalbedo = 0.9\nthickness = 2"));
  for (const Isa isa : lane_isas())
    for (const std::uint64_t max_order : {210, 1000}) {  // beyond 216 the absorbed are the rest
      const LaneSetting<float> setting(stack, plan_for(stack, isa, max_order),
                                       direction_from_degrees(30, 0), 1);
      LaneWalkTask task;
      task.walk = setting.walk;
      task.one_medium = true;
      task.index_stride = 1;
      std::array<std::uint64_t, kWalkEnds*(kRouletteOrder + 1)> ends{};
      LaneSums sums;
      sums.ends = ends.data();
      const LaneBatch batch{0, 5000, &sums};
      task.batches = &batch;
      task.batch_count = 1;
      walk_lanes_for(isa)(task);
      EXPECT_EQ(std::accumulate(ends.begin(), ends.end(), std::uint64_t{0}), 5000u);
      const auto absorbed =
          ends[static_cast<std::size_t>(WalkEnd::absorbed) * (kRouletteOrder + 1) + kRouletteOrder];
      EXPECT_GT(absorbed, 500u) << to_text(isa);
    }
}

// What no valid stack can bring about: a parameter that is not a number, put behind the reader.
TEST(LaneWalk, ADirectionThatIsNotANumberDoesNotHide) {
  const Stack stack = stack_from(layer("medium = 'henyey_greenstein'\ng = 0.5\nthickness = 2"));
  for (const Isa isa : lane_isas())
    for (const bool one_medium : {false, true})
      for (const bool broken : {false, true}) {
        LaneSetting<float> setting(stack, plan_for(stack, isa), direction_from_degrees(30, 0), 1);
        if (broken) setting.layers.value[kG][0] = std::nanf("");
        LaneWalkTask task;
        task.walk = setting.walk;
        task.one_medium = one_medium;
        task.index_stride = 1;
        std::uint64_t ends[kWalkEnds * (kRouletteOrder + 1)] = {};
        LaneSums sums;
        sums.ends = ends;
        const LaneBatch batch{0, 500, &sums};
        task.batches = &batch;
        task.batch_count = 1;
        (one_medium ? walk_lanes_for : walk_stack_lanes_for)(isa)(task);
        EXPECT_EQ(sums.finite, !broken) << to_text(isa);
      }
}

TEST(LaneSoak, TenBillionCollisionsInLambertSpheresMatchTheDeterministicSolver) {
  if (!std::getenv("LAMELLA_SOAK")) GTEST_SKIP() << "half a minute of two cores: make soak";
  const Stack stack = load_stack("lambert_sphere_halfspace");
  const Direction wi = direction_from_degrees(60, 0);
  Simulation simulation(stack, plan_for(stack, supported_isas().back()), wi, Estimator::analog,
                        CellGrid{}, 1);
  while (simulation.collisions() < 10000000000) simulation.advance(simulation.walks() + 50000000);
  const RunResult run = reduce(simulation);
  const double mu[] = {wi.z};
  const DeterministicEnergies exact = solve_deterministic(stack).energies(mu)[0];
  for (int o = 0; o <= kTallyOrders; ++o) {
    const Estimate e = o < kTallyOrders ? run.reflected.orders[o][0] : run.reflected.total[0];
    std::printf("order %s: %.7f +- %.1e, deterministic %.7f, z %.2f\n",
                o == kTallyOrders ? "all" : std::to_string(o + 1).c_str(), e.value,
                e.standard_error, exact.reflected[o].r,
                (e.value - exact.reflected[o].r) / e.standard_error);
    // The solver's own error is 1e-6 of f.
    EXPECT_NEAR(e.value, exact.reflected[o].r, 3 * e.standard_error + 1e-6 * e.value) << o;
  }
}

}  // namespace
}  // namespace lamella
