// Walks on lanes through interfaces, on every instruction set of the machine, against the scalar
// double walk, and against the same walks in double.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <map>
#include <memory>

#include "tests/volume/lanes/boundary_cases.h"
#include "tests/volume/lanes/lane_agreement.h"
#include "tests/volume/run/stacks.h"
#include "volume/lanes/lane_replay.h"
#include "volume/lanes/lane_run.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::boundary_cases;
using testing::BoundaryCase;
using testing::expect_same_lobes;
using testing::interface;
using testing::lane_isas;
using testing::layer;
using testing::stack_from;
using testing::z_between;

std::unique_ptr<Simulation> coated_in_cells(const BoundaryCase& c, Isa isa, std::uint64_t walks,
                                            std::uint64_t seed, Thinning thinning = {}) {
  const Stack stack = stack_from(c.toml);
  Plan plan = make_plan(stack, {.max_order = 1000, .thinning = thinning});
  plan.isa = isa;
  auto simulation =
      std::make_unique<Simulation>(stack, plan, direction_from_degrees(c.theta, c.phi),
                                   Estimator::analog, CellGrid{3, 4, false}, seed);
  simulation->advance(testing::soaked(walks));
  return simulation;
}

constexpr std::uint64_t kCoatedWalks = 60000;

const RunResult& coated_in_scalar(std::size_t k) {
  static std::map<std::size_t, RunResult> done;
  const auto found = done.find(k);
  if (found != done.end()) return found->second;
  return done[k] = reduce(*coated_in_cells(boundary_cases()[k], Isa::scalar, kCoatedWalks, 2));
}

class LaneBoundaries : public ::testing::TestWithParam<Isa> {};

TEST_P(LaneBoundaries, EnergiesAndCellsAgreeWithTheScalarWalk) {
  for (std::size_t k = 0; k < boundary_cases().size(); ++k) {
    const BoundaryCase& c = boundary_cases()[k];
    const auto lanes = coated_in_cells(c, GetParam(), kCoatedWalks, 1);
    ASSERT_EQ(lanes->isa(), GetParam()) << c.what;
    const RunResult a = reduce(*lanes), &b = coated_in_scalar(k);
    expect_same_lobes(a, b, c.what);
    const double events = static_cast<double>(b.collisions) / static_cast<double>(b.walks);
    EXPECT_NEAR(static_cast<double>(a.collisions) / static_cast<double>(a.walks), events,
                0.05 * events)
        << c.what;
  }
}

TEST_P(LaneBoundaries, ThinnedWalksHaveTheSameMeans) {
  for (std::size_t k = 0; k < boundary_cases().size(); ++k) {
    const BoundaryCase& c = boundary_cases()[k];
    const auto lanes = coated_in_cells(c, GetParam(), 2 * kCoatedWalks, 3, Thinning{2});
    ASSERT_EQ(lanes->isa(), GetParam()) << c.what;
    const RunResult a = reduce(*lanes);
    expect_same_lobes(a, coated_in_scalar(k), c.what);
    for (int channel = 0; channel < a.channels; ++channel)
      EXPECT_LE(std::abs(a.thinned[channel].value), allowed_z() * a.thinned[channel].standard_error)
          << c.what;
  }
}

// The same random numbers, from the same source: what differs is rounding.
TEST_P(LaneBoundaries, FloatHasNoBiasAgainstTheSameWalksInDouble) {
  constexpr std::uint64_t kReplayed = 4096;
  constexpr double kLargestBias = 1e-5;  // the bound that volume/README.md states
  double together = 0, variance = 0;
  int count = 0;
  for (const BoundaryCase& c : boundary_cases())
    for (const double mu : {1.0, 0.5, 1e-3, 0.0, -1e-7, -0.5}) {
      const Stack stack = stack_from(c.toml);
      if (mu < 0 && !stack.is_open_below()) continue;
      Plan plan = make_plan(stack, {.max_order = 300, .thinning = Thinning{}});
      plan.isa = GetParam();
      Simulation lanes(stack, plan, direction_from_mu_phi(mu, 0.3), Estimator::analog,
                       CellGrid{2, 4, false}, 3);
      lanes.advance(kReplayed);
      const auto exact =
          replay_in_double(stack, plan, lanes.incident(), 3, kBatches, kReplayed, lanes.targets());
      // What leaves in channel 0, weighed by where it leaves to; deltas are in no cell.
      const auto sum = [&](const BatchTally& b) {
        const std::size_t targets = lanes.targets().count();
        double all = b.energy.specular_up[0] + 2 * b.energy.specular_down[0] +
                     3 * b.energy.uncollided[0] + 0.5 * b.energy.lost[0];
        for (std::size_t j = 0; j < b.f.size(); ++j)
          if (j / targets % plan.channels == 0)
            all += b.f[j] *
                   (1 + 0.5 * static_cast<double>(j % targets) / static_cast<double>(targets));
        return all;
      };
      double total = 0, difference = 0, squares = 0;
      for (int k = 0; k < kBatches; ++k) {
        const double d = sum(lanes.batches()[k]) - sum(exact[k]);
        total += sum(exact[k]);
        difference += d;
        squares += d * d;
      }
      ASSERT_GT(total, 0) << c.what;
      const double relative = difference / total, error = std::sqrt(squares) / total;
      // One walk that took another turn is an error that no scatter shows.
      EXPECT_LT(std::abs(relative), kLargestBias + allowed_z() * std::max(error, 1.5 / kReplayed))
          << c.what << " mu " << mu;
      together += relative;
      variance += error * error;
      ++count;
    }
  EXPECT_LT(std::abs(together) / count, kLargestBias + allowed_z() * std::sqrt(variance) / count);
  std::printf("%s: mean relative difference of %d cases %.1e +- %.1e\n",
              to_text(GetParam()).c_str(), count, together / count, std::sqrt(variance) / count);
}

TEST_P(LaneBoundaries, IsBitIdenticalForAnyThreadsAndCheckpoints) {
  for (const std::size_t k : {0, 1, 3, 4, 7, 101, 107}) {  // beyond 100: thinned
    const auto sums = [&](int threads, const std::vector<std::uint64_t>& checkpoints) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      tbb::task_arena arena(threads);
      return arena.execute([&] {
        const auto simulation = coated_in_cells(boundary_cases()[k % 100], GetParam(), 0, 7,
                                                k > 100 ? Thinning{2} : Thinning{});
        for (const std::uint64_t walks : checkpoints) simulation->advance(walks);
        std::vector<double> all;
        for (const BatchTally& b : simulation->batches()) {
          all.insert(all.end(), b.f.begin(), b.f.end());
          for (const auto& order : b.energy.up) all.insert(all.end(), order.begin(), order.end());
          for (const auto& part : {b.energy.absorbed, b.energy.lost, b.energy.zero_up,
                                   b.energy.specular_up, b.energy.uncollided})
            all.insert(all.end(), part.begin(), part.end());
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

// In this walk Lambert's law in float sent light nowhere, once in some ten million events.
TEST_P(LaneBoundaries, LightFromTheSubstrateAlwaysHasADirection) {
  constexpr std::uint64_t kWalk = 3478918;
  const Stack stack =
      stack_from(interface("'ggx'\nior = 1.5\nroughness = 0.3\nmasking = 'correlated'") +
                 "[substrate]\nalbedo = 0.9\n");
  Plan plan = make_plan(stack);
  plan.isa = GetParam();
  LaneRun run(stack, plan, direction_from_degrees(60, 0), 1, kBatches, {});
  std::vector<BatchTally> tallies(1);
  const std::vector<LaneRun::Part> one{{kWalk / kBatches, kWalk / kBatches + 1}};
  EXPECT_NO_THROW(run.run(kWalk % kBatches, one, tallies));
}

// White stacks of smooth interfaces lose nothing; facets that hide each other do.
TEST_P(LaneBoundaries, WhiteStacksAbsorbNothing) {
  for (const auto& [toml, loses] :
       {std::pair{interface("'smooth'\nior = 1.5") + "[substrate]\nalbedo = 1\n", false},
        {interface("'smooth'\nior = 1.5") + layer("medium = 'lambert_sphere'\nthickness = 1") +
             interface("'smooth'\nior = 1"),
         false},
        {interface("'ggx'\nior = 1.5\nroughness = 0.5") + "[substrate]\nalbedo = 1\n", true}}) {
    const auto run = reduce(*coated_in_cells({"white", toml, 60, 0}, GetParam(), 20000, 5));
    EXPECT_NEAR(run.absorbed[0].value, 0, 1e-9);
    EXPECT_EQ(run.lost[0].value > 0, loses);
    EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, LaneBoundaries, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LaneBoundaries);

TEST(LaneBoundaryLimits, WhatStaysScalarIsNamed) {
  const std::string coat = interface("'ggx'\nior = 1.5\nroughness = 0.3");
  const auto reason = [](const std::string& toml) {
    const Stack stack = stack_from(toml);
    Plan plan = make_plan(stack);
    plan.isa = lane_isas().back();
    return why_not_lanes(stack, plan).value_or("");
  };
  if (lane_isas().empty()) return;
  EXPECT_EQ(reason(coat + "[substrate]\nalbedo = 0.5\n"), "");
  EXPECT_NE(reason(interface("'ggx'\nior = 1.5\nroughness = 0.3\nscattering = 'multiple'") +
                   "[substrate]\nalbedo = 0.5\n")
                .find("multiple"),
            std::string::npos);
  EXPECT_NE(reason(interface("'ggx'\nior = 1.5\nroughness = 1e-5") + "[substrate]\nalbedo = 0.5\n")
                .find("alpha"),
            std::string::npos);
  EXPECT_NE(
      reason(coat + "[substrate]\nbsdf = 'conductor'\neta = 0.2\nk = 3.9\n").find("conductor"),
      std::string::npos);
  EXPECT_NE(reason(interface("'smooth'\nior = 1.5") +
                   layer("medium = 'rayleigh'\nthickness = 1e-3") + interface("'smooth'\nior = 1"))
                .find("film"),
            std::string::npos);
}

}  // namespace
}  // namespace lamella
