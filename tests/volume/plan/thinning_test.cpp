// Thinning of long walks: its numbers, and walks with it against the deterministic solver.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_run.h"
#include "volume/plan/longest_walk.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::layer;
using testing::OnEveryIsa;
using testing::plan_of;
using testing::stack_from;

TEST(Thinning, SparesByHalvesAtEveryFourfold) {
  const Thinning thinning{16};
  for (const std::uint64_t last : {15, 16, 63, 64, 255, 256, 1 << 20, (1 << 24) - 1, 1 << 24})
    for (std::uint64_t n : {last, last + 1}) {
      const int expected =
          n < 16 ? 0 : static_cast<int>(std::floor(std::log2(static_cast<double>(n) / 16) / 2)) + 1;
      EXPECT_EQ(thinning.spared(n), std::min(expected, 11)) << n;
      EXPECT_EQ(thinning.halves_at(n), thinning.spared(n) > thinning.spared(n - 1)) << n;
      EXPECT_EQ(thinning.weight(n), std::ldexp(1.0, static_cast<int>(thinning.spared(n))));
      EXPECT_EQ(spared_of<std::uint32_t>(16, static_cast<std::uint32_t>(n)), thinning.spared(n));
    }
  EXPECT_EQ(Thinning{}.spared(1 << 20), 0u);
  EXPECT_FALSE(Thinning{}.halves_at(16));
}

// Over equidistant words: half of the walks end at the first event, a quarter at the next, ...
TEST(Thinning, EndsHalfOfWhatIsLeftEachTime) {
  std::map<std::uint32_t, int> ends;
  constexpr int kMany = 1 << 16;
  for (std::uint32_t k = 0; k < kMany; ++k) ++ends[thinned_at<std::uint32_t>(4, k << 16)];
  for (int level = 0; level < 12; ++level)
    EXPECT_EQ(ends[4u << (2 * level)], kMany >> (level + 1)) << level;
  EXPECT_EQ(ends[~0u], kMany >> 12);  // beyond 2^24 none does
}

TEST(Thinning, IsChosenWhereWalksAreLong) {
  const auto first = [](const std::string& keys) {
    return make_plan(stack_from(layer(keys))).thinning.first;
  };
  EXPECT_EQ(first("medium = 'lambert_sphere'\nalbedo = 1\nthickness = inf"), 16u);
  EXPECT_EQ(first("medium = 'lambert_sphere'\nalbedo = [0.9, 0.999, 0.9]\nthickness = inf"), 16u);
  EXPECT_EQ(first("medium = 'lambert_sphere'\nalbedo = 0.99\nthickness = inf"), 0u);
  EXPECT_EQ(first("medium = 'lambert_sphere'\nalbedo = 1\nthickness = 10"), 0u);
  EXPECT_EQ(first("medium = 'lambert_sphere'\nalbedo = 1\nthickness = 40"), 16u);
  // An event of a forward peak is a tenth of one.
  EXPECT_EQ(first("medium = 'henyey_greenstein'\ng = 0.9\nalbedo = 1\nthickness = inf"), 256u);
  EXPECT_EQ(first("medium = 'henyey_greenstein'\ng = 0.9\nalbedo = 0.99\nthickness = inf"), 0u);
  // One-sided flakes send light out again soon.
  EXPECT_EQ(first("medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 1\nthickness = inf"), 0u);
  EXPECT_EQ(first("medium = 'sggx'\nroughness = 0.5\nf0 = 0.04\nthickness = inf"), 0u);
  const Stack white = load_stack("lambert_sphere_white");
  EXPECT_EQ(make_plan(white).max_order, kThinnedMaxOrder);
  EXPECT_EQ(make_plan(white, {.thinning = Thinning{}}).max_order, kMaxOrder);
  EXPECT_EQ(make_plan(white, {.max_order = 300}).thinning.first, 0u);
}

// White in some channels only: the walk is as long as that of the white ones.
TEST(Thinning, FollowsTheBrightestChannel) {
  const std::string keys = "medium = 'vmf_flake'\nroughness = 1\nthickness = inf\nalbedo = ";
  const Stack stack = stack_from(layer(keys + "[0.504, 1, 1]"));
  Plan plan = make_plan(stack), white = make_plan(stack_from(layer(keys + "1")));
  EXPECT_EQ(plan.thinning.first, white.thinning.first);
  EXPECT_EQ(plan.thinning.first, 16u);
  EXPECT_EQ(plan.max_order, white.max_order);
  EXPECT_EQ(plan.max_order, kThinnedMaxOrder);

  const Direction wi = direction_from_degrees(45, 0);
  const double mu[] = {wi.z};
  const Rgb exact =
      solve_deterministic(stack, {.tolerance = 1e-6}).energies(mu).front().reflected[Order::all];
  EXPECT_NEAR(exact.g, 1, 1e-9);
  for (const Isa isa : {Isa::scalar, supported_isas().back()}) {
    plan.isa = isa;
    Simulation simulation(stack, plan, wi, Estimator::analog, CellGrid{4, 8, true}, 1);
    simulation.advance(isa == Isa::scalar ? 20000 : 400000);
    const RunResult run = reduce(simulation);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(ledger_sum(run, c), 1, 1e-9);
      const Estimate& found = run.reflected.total[c];
      EXPECT_LT(std::abs(found.value - exact[c]),
                allowed_z() * found.standard_error + run.unresolved[c].value)
          << to_text(isa) << ' ' << c;
    }
    EXPECT_EQ(run.unresolved[0].value, 0);
    // What a million events leave of a white half space, n^-1/2, in walks that count 512 each.
    EXPECT_LT(run.unresolved[1].value,
              1e-3 + 6 * std::sqrt(1e-3 * 512 / static_cast<double>(run.walks)));
  }
}

// The number of events after which the surviving walks have fallen by a factor e, from the shares
// that walks cut at n and at 2 n events leave unresolved: 0.25 to 1.8 times the estimate here.
// Diffusion in a slab of particles predicts 3 / pi^2 times the estimate; flakes let light out
// faster along themselves.
TEST(Thinning, KnowsHowLongTheLongestWalksAre) {
  for (const char* keys : {"medium = 'lambert_sphere'\nalbedo = 0.95\nthickness = inf",
                           "medium = 'lambert_sphere'\nalbedo = 0.99\nthickness = inf",
                           "medium = 'lambert_sphere'\nalbedo = 1\nthickness = 5",
                           "medium = 'lambert_sphere'\nalbedo = 1\nthickness = 20",
                           "medium = 'lambert_sphere'\nalbedo = 0.99\nthickness = 10",
                           "medium = 'henyey_greenstein'\ng = 0.8\nalbedo = 0.99\nthickness = inf",
                           "medium = 'henyey_greenstein'\ng = 0.8\nalbedo = 1\nthickness = 50",
                           "medium = 'sggx'\nroughness = 0.3\nalbedo = 1\nthickness = 20",
                           "medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 1\nthickness = inf"}) {
    const Stack stack = stack_from(layer(keys));
    const double estimate = longest_walk(stack, make_plan(stack).layers);
    const auto left = [&](double events) {
      Plan plan = make_plan(
          stack, {.max_order = static_cast<std::uint64_t>(events), .thinning = Thinning{}});
      plan.isa = supported_isas().back();
      Simulation s(stack, plan, direction_from_degrees(30, 0), std::vector<Direction>{}, 1);
      s.advance(400000);
      return batch_estimate(s.batches(), [](const BatchTally& b) { return b.energy.unresolved[0]; })
          .value;
    };
    const double n = std::ceil(estimate);
    const double measured = n / std::log(left(n) / left(2 * n));
    EXPECT_LT(measured, 5 * estimate) << keys;
    EXPECT_GT(measured, estimate / 5) << keys;
  }
}

// Deep and nearly white, in one medium, in colour and among layers; each cell and energy against
// the solver, the scalar kernel like the lanes.
class ThinnedWalks : public OnEveryIsa {};

const std::vector<std::string>& deep_stacks() {
  static const std::vector<std::string> list{
      layer("medium = 'lambert_sphere'\nalbedo = 1\nthickness = 30"),
      layer("medium = 'lambert_sphere'\nalbedo = [0.9999, 0.99, 0.5]\nthickness = inf"),
      layer("medium = 'henyey_greenstein'\ng = 0.5\nalbedo = 1\nthickness = 30") +
          layer("medium = 'lambert_sphere'\nalbedo = 0.9999\nthickness = 20") +
          "[substrate]\nbsdf = 'lambert'\nalbedo = 0.99\n",
  };
  return list;
}

const DeterministicSolution& solved(std::size_t k) {
  static std::map<std::size_t, DeterministicSolution> done;
  const auto found = done.find(k);
  if (found != done.end()) return found->second;
  return done.emplace(k, solve_deterministic(stack_from(deep_stacks()[k]), {.tolerance = 1e-6}))
      .first->second;
}

TEST_P(ThinnedWalks, EnergiesAreThoseOfTheSolver) {
  for (std::size_t k = 0; k < deep_stacks().size(); ++k) {
    const Stack stack = stack_from(deep_stacks()[k]);
    Plan plan = plan_of(stack, 60000);
    ASSERT_EQ(plan.thinning.first, k == 2 ? 32u : 16u);
    const Direction wi = direction_from_degrees(60, 0);
    const double mu[] = {wi.z};
    const DeterministicEnergies exact = solved(k).energies(mu).front();
    Simulation simulation(stack, plan, wi, Estimator::analog, CellGrid{4, 8, true}, 1);
    ASSERT_EQ(simulation.isa(), plan.isa);
    simulation.advance(testing::soaked(plan.isa == Isa::scalar ? 30000 : 300000));
    const RunResult run = reduce(simulation);
    const auto expect = [&](Estimate found, double expected, const std::string& what) {
      EXPECT_LT(std::abs(found.value - expected), allowed_z() * found.standard_error + 2e-6)
          << deep_stacks()[k] << what << ' ' << found.value << ' ' << expected;
    };
    for (int c = 0; c < run.channels; ++c) {
      EXPECT_NEAR(ledger_sum(run, c), 1, 1e-9);
      for (int o = 0; o < kTallyOrders; ++o) {
        expect(run.reflected.orders[o][c], exact.reflected[o][c], "reflected");
        expect(run.transmitted.orders[o][c], exact.transmitted[o][c], "transmitted");
      }
      expect(run.absorbed[c], exact.absorbed[c] - run.unresolved[c].value, "absorbed");
      EXPECT_LT(run.unresolved[c].value, 2e-3);
      expect(run.thinned[c], 0, "thinned");
      EXPECT_GT(run.thinned[c].standard_error, 0);
      // What absorbs nothing has nothing absorbed, whatever thinning does.
      if (k == 0) {
        EXPECT_NEAR(run.absorbed[c].value, 0, 1e-12);
      }
    }
  }
}

TEST_P(ThinnedWalks, PointsAreThoseOfTheSolver) {
  const std::vector<Direction> points{direction_from_mu_phi(0.9, 1), direction_from_mu_phi(0.1, 0)};
  for (std::size_t k = 0; k < deep_stacks().size(); ++k) {
    const Stack stack = stack_from(deep_stacks()[k]);
    const Plan plan = plan_of(stack, 60000);
    const Direction wi = direction_from_degrees(60, 0);
    Simulation simulation(stack, plan, wi, points, 1);
    ASSERT_EQ(simulation.isa(), plan.isa);
    simulation.advance(testing::soaked(plan.isa == Isa::scalar ? 20000 : 100000));
    for (int j = 0; j < 2; ++j) {
      const DeterministicValue exact = solved(k).f(wi, points[j]);
      for (int c = 0; c < plan.channels; ++c)
        for (int o = 0; o < kTallyOrders; ++o) {
          const Estimate found = testing::point_estimate(simulation, o, j, 2, c);
          EXPECT_LT(std::abs(found.value - exact.order[o][c]),
                    allowed_z() * found.standard_error + 2e-3 * exact.order[o][c])
              << deep_stacks()[k] << j << ' ' << o << ' ' << found.value;
        }
    }
  }
}

// Where walks count for many, next-event terms are rounded to multiples of up to 2^-26 instead of
// 2^-32. The walks are the same, absorption ends them long before either limit.
TEST_P(ThinnedWalks, CoarserTermsMoveCellsByLessThanAMillionth) {
  if (GetParam() == Isa::scalar) GTEST_SKIP() << "nothing is rounded";
  const Stack stack =
      stack_from(layer("medium = 'henyey_greenstein'\ng = 0.7\nalbedo = 0.8\nthickness = 4"));
  const CellGrid grid{16, 32, true};
  std::vector<std::vector<double>> f;
  for (const auto& [max_order, bits] : {std::pair{200, 0}, std::pair{1 << 24, 6}}) {
    Plan plan = make_plan(stack, {.max_order = max_order, .thinning = Thinning{4}});
    plan.isa = GetParam();
    EXPECT_EQ(coarser_bits_in_cells(stack, plan, grid), bits);
    Simulation s(stack, plan, direction_from_degrees(60, 0), Estimator::next_event, grid, 1);
    s.advance(2000);
    EXPECT_EQ(s.isa(), GetParam());
    f.emplace_back();
    for (const BatchTally& b : s.batches()) f.back().insert(f.back().end(), b.f.begin(), b.f.end());
  }
  double sum = 0, difference = 0, absolute = 0;
  for (std::size_t k = 0; k < f[0].size(); ++k) {
    sum += f[0][k];
    difference += f[1][k] - f[0][k];
    absolute += std::abs(f[1][k] - f[0][k]);
  }
  EXPECT_LT(std::abs(difference) / sum, 1e-8);  // is 7e-10
  EXPECT_LT(absolute / sum, 1e-6);              // is 5e-8
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, ThinnedWalks, ::testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return to_text(isa.param); });

}  // namespace
}  // namespace lamella
