// Walks on lanes through whole stacks, on every instruction set of the machine, against the scalar
// double kernel.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstdlib>
#include <memory>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/lanes/lane_agreement.h"
#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_run.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::expect_same_lobes;
using testing::lane_isas;
using testing::layer;
using testing::stack_from;
using testing::z_between;

struct StackCase {
  const char* what;
  std::string toml;
  double theta, phi;
};

// Several layers and media, weights of every kind, substrates, light from both sides.
const std::vector<StackCase>& stack_cases() {
  const std::string hg = "medium = 'henyey_greenstein'\ng = 0.7\n";
  static const std::vector<StackCase> list{
      {"two rough surfaces, one albedo",
       layer("medium = 'sggx'\nroughness = 0.5\nalbedo = 0.9\nthickness = 0.5") +
           layer("medium = 'sggx'\nroughness = 0.9\nalbedo = 0.9\nthickness = 2"),
       60, 0},
      {"fibers, one colour, from below",
       layer("medium = 'sggx'\nshape = 'fiber'\nroughness = 0.3\nalbedo = [0.9, 0.6, 0]\n"
             "thickness = 1") +
           layer("medium = 'sggx'\nshape = 'fiber'\nroughness = 1\nalbedo = [0.9, 0.6, 0]\n"
                 "thickness = 0.4"),
       125, 40},
      {"one layer of one colour",
       layer("medium = 'lambert_sphere'\nalbedo = [0.18, 0.05, 0.6]\nthickness = inf"), 50, 10},
      {"a leaf: Schlick mirrors about particles",
       layer("medium = 'sggx'\nroughness = 0.2\nf0 = 0.1\nthickness = 0.3") +
           layer(hg + "albedo = 0.95\nthickness = 1") +
           layer("medium = 'sggx'\nroughness = 0.3\nthickness = 0.1"),
       70, 0},
      {"colours apart over a coloured substrate",
       layer("medium = 'sggx'\nmatrix = [0.5, 0.3, 0.8, 0.1, -0.2, 0.15]\n"
             "albedo = [0.9, 0.5, 0.2]\nf0 = [0.9, 0.5, 0.3]\nthickness = 0.4") +
           layer("medium = 'lambert_sphere'\nalbedo = [0.5, 0.9, 0.8]\nthickness = 1") +
           "[substrate]\nalbedo = [0.3, 0.6, 0.9]\n",
       40, 200},
      {"vMF flakes over spheres over black",
       layer("medium = 'vmf_flake'\nroughness = 0.4\nalbedo = 0.9\nthickness = 0.7") +
           layer("medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = 0.5") +
           layer("medium = 'vmf_flake'\nroughness = 0.6\nflake = 'mirror'\nalbedo = 0.8\n"
                 "thickness = 0.5") +
           "[substrate]\nalbedo = 0\n",
       65, 0},
      {"vMF mirrors with Schlick's factor",
       layer("medium = 'vmf_flake'\nroughness = 0.6\nflake = 'mirror'\nf0 = [0.9, 0.6, 0.5]\n"
             "thickness = 1.5"),
       30, 0},
      {"Lambertian flakes above a half space",
       layer("medium = 'sggx'\nflake = 'lambert'\nroughness = 0.4\naxis = [0.3, 0, 1]\n"
             "albedo = 0.9\nthickness = 1") +
           layer(hg + "albedo = 0.8\nthickness = inf"),
       75, 30},
  };
  return list;
}

std::unique_ptr<Simulation> in_cells(const StackCase& c, Isa isa, Estimator estimator,
                                     std::uint64_t walks, std::uint64_t seed,
                                     Thinning thinning = {}) {
  const Stack stack = stack_from(c.toml);
  Plan plan = make_plan(stack);
  plan.thinning = thinning;
  plan.isa = isa;
  auto simulation = std::make_unique<Simulation>(
      stack, plan, direction_from_degrees(c.theta, c.phi), estimator, CellGrid{3, 4, false}, seed);
  simulation->advance(testing::soaked(walks));
  return simulation;
}

constexpr std::uint64_t kAnalogWalks = 60000, kNextEventWalks = 8000;

const RunResult& in_scalar(std::size_t k, Estimator estimator) {
  static std::map<std::pair<std::size_t, Estimator>, RunResult> done;
  const auto found = done.find({k, estimator});
  if (found != done.end()) return found->second;
  const std::uint64_t walks = estimator == Estimator::analog ? kAnalogWalks : kNextEventWalks;
  return done[{k, estimator}] =
             reduce(*in_cells(stack_cases()[k], Isa::scalar, estimator, walks, 2));
}

class LaneStack : public ::testing::TestWithParam<Isa> {};

TEST_P(LaneStack, EnergiesAndCellsAgreeWithTheScalarKernel) {
  for (std::size_t k = 0; k < stack_cases().size(); ++k) {
    const StackCase& c = stack_cases()[k];
    const auto lanes = in_cells(c, GetParam(), Estimator::analog, kAnalogWalks, 1);
    ASSERT_EQ(lanes->isa(), GetParam()) << c.what;
    EXPECT_GT(lanes->lane_use()->occupancy, 0.3) << c.what;
    const RunResult a = reduce(*lanes), &b = in_scalar(k, Estimator::analog);
    expect_same_lobes(a, b, c.what);
    const double events = static_cast<double>(b.collisions) / static_cast<double>(b.walks);
    EXPECT_NEAR(static_cast<double>(a.collisions) / static_cast<double>(a.walks), events,
                0.05 * events)
        << c.what;
  }
}

TEST_P(LaneStack, NextEventInCellsAgreesWithTheScalarKernel) {
  for (std::size_t k = 0; k < stack_cases().size(); ++k) {
    const StackCase& c = stack_cases()[k];
    const auto lanes = in_cells(c, GetParam(), Estimator::next_event, kNextEventWalks, 1);
    ASSERT_EQ(lanes->isa(), GetParam()) << c.what;
    expect_same_lobes(reduce(*lanes), in_scalar(k, Estimator::next_event), c.what);
  }
}

// From the second event on, so that every stack has walks that are thinned more than once.
constexpr Thinning kEarly{2};

TEST_P(LaneStack, ThinnedWalksHaveTheSameMeans) {
  for (std::size_t k = 0; k < stack_cases().size(); ++k)
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const StackCase& c = stack_cases()[k];
      const std::uint64_t walks = estimator == Estimator::analog ? kAnalogWalks : kNextEventWalks;
      const auto lanes = in_cells(c, GetParam(), estimator, 2 * walks, 3, kEarly);
      ASSERT_EQ(lanes->isa(), GetParam()) << c.what;
      const RunResult a = reduce(*lanes), &b = in_scalar(k, estimator);
      expect_same_lobes(a, b, c.what);
      for (int channel = 0; channel < a.channels; ++channel)
        EXPECT_LT(std::abs(a.thinned[channel].value),
                  allowed_z() * a.thinned[channel].standard_error)
            << c.what;
      EXPECT_LT(static_cast<double>(a.collisions) / static_cast<double>(a.walks),
                0.97 * static_cast<double>(b.collisions) / static_cast<double>(b.walks))
          << c.what;
    }
}

TEST_P(LaneStack, PointsAgreeWithTheScalarKernel) {
  for (const StackCase& c : stack_cases())
    for (const int count : {1, 9, -1, -9}) {  // one direction after the other, and many at once
      const Stack stack = stack_from(c.toml);
      std::vector<Direction> points;
      for (const double sign : {1.0, -1.0})
        for (int j = 0; j < std::abs(count) && (sign > 0 || stack.is_open_below()); ++j)
          points.push_back(
              direction_from_mu_phi(sign * (j + 0.6) / std::abs(count), 0.7 + 2.4 * j));
      const int n = static_cast<int>(points.size());
      Plan plan = make_plan(stack);
      Simulation scalar(stack, plan, direction_from_degrees(c.theta, c.phi), points, 2);
      plan.isa = GetParam();
      if (count < 0) plan.thinning = kEarly;
      Simulation lanes(stack, plan, direction_from_degrees(c.theta, c.phi), points, 1);
      ASSERT_EQ(lanes.isa(), GetParam()) << c.what;
      scalar.advance(testing::soaked(10000));
      lanes.advance(testing::soaked(10000));
      for (int j = 0; j < n; ++j)
        for (int o = 0; o <= kTallyOrders; ++o)
          for (int channel = 0; channel < plan.channels; ++channel) {
            const Estimate x = testing::point_estimate(lanes, o, j, n, channel);
            const Estimate y = testing::point_estimate(scalar, o, j, n, channel);
            if (x.value < 6 * x.standard_error || y.value < 6 * y.standard_error) continue;
            EXPECT_LT(std::abs(z_between(x, y)), allowed_z())
                << c.what << " point " << j << " order " << o << " channel " << channel << ' '
                << x.value << ' ' << y.value;
          }
    }
}

TEST_P(LaneStack, PointsHaveTheSameValuesInWhateverCompany) {
  // Few points are taken one after the other, more of them many at once; where the line is depends
  // on the stack. The walks are the same, so that only rounding differs.
  std::vector<StackCase> cases = stack_cases();
  for (const char* medium :
       {"medium = 'henyey_greenstein'\ng = 0.7", "medium = 'sggx'\nroughness = 0.5",
        "medium = 'sggx'\nroughness = 0.4\nflake = 'lambert'", "medium = 'lambert_sphere'",
        "medium = 'vmf_flake'\nroughness = 0.5\nflake = 'mirror'"})
    cases.push_back({medium, layer(std::string(medium) + "\nalbedo = 0.9\nthickness = 2"), 60, 0});
  for (const StackCase& c : cases) {
    const Stack stack = stack_from(c.toml);
    Plan plan = make_plan(stack);
    plan.isa = GetParam();
    std::vector<std::vector<double>> f;
    std::size_t few = 0;
    for (const int copies : {1, 2, 3, 7, 20}) {
      std::vector<Direction> points;
      for (const double sign : {1.0, -1.0})
        for (int j = 0; j < 2 * copies && (sign > 0 || stack.is_open_below()); ++j)
          points.push_back(direction_from_mu_phi(sign * (j % 2 ? 0.9 : 0.3), j % 2 ? 2 : 0.7));
      Simulation s(stack, plan, direction_from_degrees(c.theta, c.phi), points, 1);
      ASSERT_EQ(s.isa(), GetParam()) << c.what;
      s.advance(2000);
      if (copies == 1) few = points.size();
      f.emplace_back();
      for (int o = 0; o <= kTallyOrders; ++o)
        for (int channel = 0; channel < plan.channels; ++channel)
          for (std::size_t j = 0; j < few; ++j)
            f.back().push_back(testing::point_estimate(s, o,
                                                       static_cast<int>(j / 2 * 2 * copies + j % 2),
                                                       static_cast<int>(points.size()), channel)
                                   .value);
      for (std::size_t j = 0; j < f[0].size(); ++j)
        EXPECT_NEAR(f.back()[j], f[0][j], 1e-6 * f[0][j] + 1e-9) << c.what << ' ' << points.size();
    }
  }
}

TEST_P(LaneStack, IsBitIdenticalForAnyThreadsAndCheckpoints) {
  for (const std::size_t k : {1, 4, 5, 101, 104, 105})  // beyond 100: thinned
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const auto sums = [&](int threads, const std::vector<std::uint64_t>& checkpoints) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        tbb::task_arena arena(threads);
        return arena.execute([&] {
          const auto simulation = in_cells(stack_cases()[k % 100], GetParam(), estimator, 0, 7,
                                           k > 100 ? kEarly : Thinning{});
          for (const std::uint64_t walks : checkpoints) simulation->advance(walks);
          std::vector<double> all;
          for (const BatchTally& b : simulation->batches()) {
            all.insert(all.end(), b.f.begin(), b.f.end());
            for (const auto& order : b.energy.up) all.insert(all.end(), order.begin(), order.end());
            all.insert(all.end(), b.energy.absorbed.begin(), b.energy.absorbed.end());
          }
          all.push_back(static_cast<double>(simulation->collisions()));
          return all;
        });
      };
      const auto one = sums(1, {5000});
      EXPECT_EQ(one, sums(2, {5000}));
      EXPECT_EQ(one, sums(7, {1, 130, 131, 2048, 4999, 5000}));
    }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, LaneStack, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LaneStack);

}  // namespace
}  // namespace lamella
