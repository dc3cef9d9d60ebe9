// Walks on lanes whose first numbers are those of lattices: bits, bias and variance.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <memory>

#include "phase/random/lattice.h"
#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/stacks.h"
#include "tests/volume/run/tally_sums.h"
#include "volume/lanes/lane_replay.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::lane_isas;
using testing::layer;
using testing::stack_from;

Plan sampled_plan(const Stack& stack, Isa isa, Sampling sampling, Thinning thinning = {}) {
  Plan plan = make_plan(stack, {.max_order = 300, .thinning = thinning, .sampling = sampling});
  plan.isa = isa;
  return plan;
}

enum class Task { analog, next_event, points };
std::unique_ptr<Simulation> simulation_of(const Stack& stack, const Plan& plan, Task task,
                                          std::uint64_t seed) {
  const Direction wi = direction_from_degrees(60, 20);
  if (task == Task::points)
    return std::make_unique<Simulation>(
        stack, plan, wi,
        std::vector<Direction>{direction_from_degrees(30, 50), direction_from_degrees(70, 10)},
        seed);
  return std::make_unique<Simulation>(
      stack, plan, wi, task == Task::analog ? Estimator::analog : Estimator::next_event,
      CellGrid{4, 8, false}, seed);
}

// One medium, weights, several layers, interfaces; each also thinned.
std::vector<std::string> lattice_stacks() {
  return {layer("medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = inf"),
          layer("medium = 'vmf_flake'\nroughness = 0.5\nalbedo = [0.9, 0.5, 0.2]\nthickness = 3"),
          layer("medium = 'sggx'\nroughness = 0.4\nf0 = 0.3\nalbedo = 0.95\nthickness = 2"),
          layer("medium = 'henyey_greenstein'\ng = 0.6\nalbedo = 0.9\nthickness = 1") +
              layer("medium = 'vmf_flake'\nroughness = 0.4\nalbedo = 0.8\nthickness = 1") +
              "[substrate]\nalbedo = 0.5\n",
          layer("interface = 'ggx'\nior = 1.5\nroughness = 0.3") +
              layer("medium = 'lambert_sphere'\nalbedo = 0.9\nthickness = inf"),
          layer("interface = 'smooth'\nior = 1.4") +
              layer("medium = 'henyey_greenstein'\ng = 0.5\nalbedo = 0.9\nthickness = 1") +
              "[substrate]\nalbedo = 0.6\n",
          layer("interface = 'ggx'\nior = 1.5\nroughness = 0.2") + "[substrate]\nalbedo = 0.8\n"};
}

class LaneLattice : public ::testing::TestWithParam<Isa> {};

TEST_P(LaneLattice, IsBitIdenticalForAnyThreadsAndCheckpoints) {
  for (const std::string& toml : lattice_stacks())
    for (const Thinning thinning : {Thinning{}, Thinning{2}})
      for (const Task task : {Task::analog, Task::next_event, Task::points}) {
        const auto sums = [&](int threads, const std::vector<std::uint64_t>& checkpoints) {
          const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
          tbb::task_arena arena(threads);
          return arena.execute([&] {
            const Stack stack = stack_from(toml);
            const auto simulation = simulation_of(
                stack, sampled_plan(stack, GetParam(), Sampling::rqmc, thinning), task, 7);
            EXPECT_EQ(simulation->sampling(), Sampling::rqmc);
            for (const std::uint64_t walks : checkpoints) simulation->advance(walks);
            return testing::tally_sums(*simulation);
          });
        };
        const auto one = sums(1, {3000});
        // With 64 threads thinned batches do not share their lanes.
        EXPECT_EQ(one, sums(64, {3000})) << toml;
        EXPECT_EQ(one, sums(3, {1, 130, 131, 2048, 2999, 3000})) << toml;
      }
}

TEST_P(LaneLattice, EstimatesAgreeWithRandomWalks) {
  constexpr std::uint64_t kWalks = 60000;
  for (const std::string& toml : lattice_stacks())
    for (const Thinning thinning : {Thinning{}, Thinning{2}})
      for (const Task task : {Task::analog, Task::next_event, Task::points}) {
        const Stack stack = stack_from(toml);
        std::unique_ptr<Simulation> by[2];
        for (const Sampling sampling : {Sampling::random, Sampling::rqmc}) {
          auto& simulation = by[sampling == Sampling::rqmc ? 1 : 0];
          simulation =
              simulation_of(stack, sampled_plan(stack, GetParam(), sampling, thinning), task, 11);
          simulation->advance(testing::soaked(kWalks) / (task == Task::next_event ? 4 : 1));
        }
        const auto agree = [&](const char* what, auto of) {
          const Estimate a = batch_estimate(by[0]->batches(), of);
          const Estimate b = batch_estimate(by[1]->batches(), of);
          EXPECT_NEAR(a.value, b.value,
                      allowed_z() * std::hypot(a.standard_error, b.standard_error) + 1e-9)
              << what << ", task " << static_cast<int>(task) << "\n"
              << toml;
        };
        for (int k = 0; k < kTallyOrders; ++k) {
          agree("up", [k](const BatchTally& b) { return b.energy.up[k][0]; });
          agree("down", [k](const BatchTally& b) { return b.energy.down[k][0]; });
        }
        agree("absorbed", [](const BatchTally& b) { return b.energy.absorbed[0]; });
        const std::size_t targets = by[0]->batches()[0].f.size() / kTallyOrders;
        for (int slot = 0; slot < kTallyOrders; ++slot)
          for (std::size_t j = 0; j < targets; j += targets / 2)
            agree("f", [&](const BatchTally& b) {
              double sum = 0;
              for (std::size_t k = j; k < j + targets / 2; ++k) sum += b.f[slot * targets + k];
              return sum;
            });
      }
}

TEST_P(LaneLattice, FloatLanesTakeTheSameWalksAsDouble) {
  constexpr std::uint64_t kWalks = 4096;
  for (const std::string& toml : lattice_stacks())
    for (const Thinning thinning : {Thinning{}, Thinning{2}}) {
      const Stack stack = stack_from(toml);
      const Plan plan = sampled_plan(stack, GetParam(), Sampling::rqmc, thinning);
      const auto lanes = simulation_of(stack, plan, Task::analog, 3);
      lanes->advance(kWalks);
      const auto exact =
          replay_in_double(stack, plan, lanes->incident(), 3, kBatches, kWalks, lanes->targets());
      double off = 0, all = 0;
      for (int k = 0; k < kBatches; ++k)
        for (int order = 0; order < kTallyOrders; ++order) {
          const double here = lanes->batches()[k].energy.up[order][0];
          off += std::abs(here - exact[k].energy.up[order][0]);
          all += here;
        }
      // Now and then rounding leads a walk another way.
      EXPECT_LT(off, 0.005 * all) << toml;
      EXPECT_GT(all, 0.05 * kWalks) << toml;
    }
}

// A batch that goes on beyond a whole lattice, in one piece and in many; thinned batches alone and
// together.
TEST_P(LaneLattice, TheNextLatticeBeginsAfterAWholeOne) {
  const Stack stack = stack_from(lattice_stacks()[0]);
  constexpr std::uint64_t kWalks = kBatches * (kLatticePoints + 200);
  for (const Thinning thinning : {Thinning{}, Thinning{2}}) {
    const auto sums = [&](BatchRange range, const std::vector<std::uint64_t>& checkpoints) {
      const auto simulation = simulation_of(
          stack, sampled_plan(stack, GetParam(), Sampling::rqmc, thinning), Task::analog, 5);
      simulation->walk_only(range);
      for (const std::uint64_t walks : checkpoints) simulation->advance(walks);
      const BatchTally& batch = simulation->batches()[5];
      EXPECT_EQ(batch.walks, kLatticePoints + 200);
      std::vector<double> all = batch.f;
      for (const auto& order : batch.energy.up) all.push_back(order[0]);
      return all;
    };
    const auto alone = sums({5, 6}, {kWalks});
    EXPECT_EQ(alone, sums({5, 6}, {kWalks / 3, kWalks - kBatches * 300, kWalks - 5, kWalks}));
    EXPECT_EQ(alone, sums({4, 7}, {kWalks}));
  }
}

// Variances of reflected order 2, cells by next-event estimation, and of the energy of order 1, the
// latter of counted walks; 8192 walks a batch. Measured: 5.8 and 12, here half of them.
TEST_P(LaneLattice, LowersVariances) {
  const Stack stack = load_stack("lambert_sphere_halfspace");
  const Direction wi = direction_from_degrees(60, 0);
  const auto variance = [&](Sampling sampling, Estimator estimator, std::uint64_t walks) {
    double sum = 0;
    for (const std::uint64_t seed : {1, 2, 3}) {
      Simulation simulation(stack, sampled_plan(stack, GetParam(), sampling), wi, estimator,
                            CellGrid{4, 8, true}, seed);
      simulation.advance(walks);
      const RunResult run = reduce(simulation);
      if (estimator == Estimator::analog)
        sum += std::pow(run.reflected.orders[0][0].standard_error, 2);
      else
        for (const double se : run.reflected.lobes[Order::two].standard_error) sum += se * se;
    }
    return sum;
  };
  const auto ratio = [&](Estimator estimator, std::uint64_t walks) {
    return variance(Sampling::random, estimator, walks) /
           variance(Sampling::rqmc, estimator, walks);
  };
  EXPECT_GT(ratio(Estimator::analog, kBatches * 8192), 6);
  EXPECT_GT(ratio(Estimator::next_event, kBatches * 2048), 2);
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, LaneLattice, ::testing::ValuesIn(lane_isas()),
                         [](const auto& isa) { return to_text(isa.param); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LaneLattice);

TEST(Sampling, OfLayersIsByLatticesOnLanesAlone) {
  const Stack coated = load_stack("coated_lambert_sphere");
  const Plan plan = make_plan(coated, {.sampling = Sampling::rqmc});
  EXPECT_EQ(plan.sampling, Sampling::rqmc);
  const Stack spheres = load_stack("lambert_sphere_halfspace");
  const Simulation scalar(spheres, sampled_plan(spheres, Isa::scalar, Sampling::rqmc),
                          direction_from_degrees(60, 0), Estimator::analog, CellGrid{}, 1);
  EXPECT_EQ(scalar.sampling(), Sampling::random);
}

}  // namespace
}  // namespace lamella
