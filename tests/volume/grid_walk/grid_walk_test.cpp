#include "volume/grid_walk/grid_walk.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/grid_walk/agreement.h"
#include "volume/voxels/depth_profile.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::collect_z;
using testing::expect_normal;
using testing::expect_same;
using testing::grid_layer;
using testing::layer;
using testing::plan_with;
using testing::run_of;
using testing::scrambled;
using testing::shared_voxels_of;
using testing::stack_from;
using testing::z_between;

// Runs a stack with a grid and one without from two sides, with different seeds.
std::vector<std::pair<RunResult, RunResult>> pairs_of(const Stack& grid, const Plan& grid_plan,
                                                      const Stack& layers,
                                                      std::uint64_t walks = 60000) {
  Plan plan = make_plan(layers);
  plan.folded = false;
  plan.channels = grid_plan.channels;
  std::vector<std::pair<RunResult, RunResult>> runs;
  for (const double theta : {50.0, 130.0}) {
    if (theta > 90 && !layers.is_open_below()) continue;
    const Direction wi = direction_from_degrees(theta, 25);
    runs.emplace_back(run_of(grid, grid_plan, wi, Estimator::analog, walks, 1),
                      run_of(layers, plan, wi, Estimator::analog, walks, 2));
  }
  return runs;
}

TEST(GridWalk, AConstantGridIsTheHomogeneousLayer) {
  std::vector<double> z;
  for (const std::string& medium : testing::every_medium()) {
    const std::string keys = medium + "\nalbedo = 0.8\nthickness = 0.5\ndensity = ";
    const Stack grid = stack_from(grid_layer(keys + "4"));
    const auto voxels = shared_voxels_of({9, 16, 5}, [](VoxelIndex) { return 0.5; });
    expect_same(pairs_of(grid, plan_with(grid, {voxels}), stack_from(layer(keys + "2")), 40000),
                medium, z);
  }
  expect_normal(z);
}

TEST(GridWalk, AGridOverASubstrateIsTheHomogeneousLayerOverIt) {
  const std::string keys =
      "medium = 'henyey_greenstein'\ng = 0.4\nalbedo = [0.9, 0.5, 0.7]\nthickness = 0.5\n";
  const std::string base = "[substrate]\nalbedo = [0.5, 0.9, 0.1]\n";
  const Stack grid = stack_from(grid_layer(keys + "density = 2") + base);
  const auto voxels = shared_voxels_of({4, 4, 4}, [](VoxelIndex) { return 1.0; });
  std::vector<double> z;
  expect_same(
      pairs_of(grid, plan_with(grid, {voxels}), stack_from(layer(keys + "density = 2") + base)),
      "substrate", z);
}

TEST(GridWalk, AGridThatVariesWithDepthIsTheStackOfItsSlices) {
  std::vector<double> z;
  const auto voxels = shared_voxels_of({6, 6, 20}, [](VoxelIndex i) {
    return i[2] == 7 ? 0 : 2 * scrambled({0, 0, i[2]});
  });
  for (const std::string& medium :
       {std::string("medium = 'sggx'\nshape = 'fiber'\nroughness = 0.3\naxis = [1, 0.4, 0.3]"),
        std::string("medium = 'vmf_flake'\nroughness = 0.5"),
        std::string("medium = 'henyey_greenstein'\ng = 0.6")}) {
    const Stack grid =
        stack_from(grid_layer(medium + "\nalbedo = 0.9\nthickness = 0.5\ndensity = 5"));
    const Plan plan = plan_with(grid, {voxels});
    const Stack slices = homogenised(grid, plan.grids);
    EXPECT_EQ(slices.layers.size(), 20u);
    expect_same(pairs_of(grid, plan, slices), medium, z);
  }
  expect_normal(z);
}

TEST(GridWalk, OrientationRoughnessAndAlbedoGridsAreTheTiltedRoughColouredLayer) {
  std::vector<double> z;
  Voxels voxels = testing::voxels_of({10, 4, 6}, [](VoxelIndex) { return 1.0; });
  voxels.orientation.emplace(voxels.extent());
  voxels.orientation->fill({0, 0, 0}, {10, 4, 6}, {3, -1, 2});
  voxels.roughness.emplace(voxels.extent());
  voxels.roughness->fill({0, 0, 0}, {10, 4, 6}, {0.5f});
  voxels.albedo.emplace(voxels.extent());
  voxels.albedo->fill({0, 0, 0}, {10, 4, 6}, {0.5f, 1, 0.75f});
  const auto shared = std::make_shared<const Voxels>(std::move(voxels));
  for (const char* medium : {"medium = 'sggx'\nshape = 'fiber'\nflake = 'mirror'\nf0 = 0.2",
                             "medium = 'sggx'", "medium = 'sggx'\nflake = 'lambert'",
                             "medium = 'vmf_flake'\nflake = 'mirror'", "medium = 'vmf_flake'"}) {
    const std::string keys = std::string(medium) + "\nthickness = 1\ndensity = 1.5\n";
    const Stack grid = stack_from(grid_layer(keys + "albedo = 0.8\nroughness = 0.9"));
    const Stack tilted =
        stack_from(layer(keys + "albedo = [0.4, 0.8, 0.6]\nroughness = 0.5\naxis = [3, -1, 2]"));
    expect_same(pairs_of(grid, plan_with(grid, {shared}), tilted, 40000), medium, z);
  }
  expect_normal(z);
}

TEST(GridWalk, NextEventAgreesWithAnalogOnEveryBuiltinGrid) {
  for (const char* name : {"woven_cloth", "settled_dust", "blotchy_layer"}) {
    const Stack stack = load_stack(name);
    Plan plan = make_plan(stack);
    const Direction wi = direction_from_degrees(55, 30);
    const RunResult a = run_of(stack, plan, wi, Estimator::analog, 150000, 1);
    for (const Isa isa : supported_isas()) {  // of the shadow rays
      plan.isa = isa;
      const RunResult n = run_of(stack, plan, wi, Estimator::next_event, 20000, 2);
      std::vector<double> z;
      collect_z(a, n, z);
      ASSERT_GT(z.size(), 30u) << name;
      for (const double x : z)
        EXPECT_LT(std::abs(x), 1.3 * allowed_z()) << name << ' ' << to_text(isa);
    }
  }
}

TEST(GridWalk, LedgerSumsToOneAndWhiteStacksKeepTheirEnergy) {
  for (const char* name : {"woven_cloth", "settled_dust", "blotchy_layer"}) {
    const Stack as_is = load_stack(name);
    const RunResult run =
        run_of(as_is, make_plan(as_is), direction_from_degrees(70, 30), Estimator::analog, 5000, 1);
    for (int c = 0; c < run.channels; ++c)
      EXPECT_NEAR(ledger_sum(run, c), 1, 1e-12) << name;  // rounding of 5000 sums
    const Stack white = whitened(as_is);
    const Plan plan = make_plan(white);
    EXPECT_EQ(plan.channels, 1);
    const RunResult analog =
        run_of(white, plan, direction_from_degrees(40, 0), Estimator::analog, 20000, 1);
    EXPECT_EQ(analog.absorbed[0].value, 0) << name;
    EXPECT_EQ(analog.unresolved[0].value, 0) << name;
    Simulation next(white, plan, direction_from_degrees(40, 0), Estimator::next_event,
                    CellGrid{4, 8, false}, 2);
    next.advance(testing::soaked(4000));
    const double solid_angle = next.targets().grid.projected_solid_angle();
    const Estimate energy = batch_estimate(next.batches(), [&](const BatchTally& b) {
      double sum = b.energy.uncollided[0];
      for (const double f : b.f) sum += solid_angle * f;
      return sum;
    });
    EXPECT_NEAR(energy.value, 1, allowed_z() * energy.standard_error) << name;
  }
}

Estimate at_point(const Stack& stack, const Plan& plan, Direction wi, Direction wo,
                  std::uint64_t walks, std::uint64_t seed) {
  Simulation simulation(stack, plan, wi, {wo}, seed);
  simulation.advance(testing::soaked(walks));
  return testing::point_estimate(simulation, kTallyOrders, 0, 1, 0);
}

TEST(GridWalk, TheTilesMeanIsReciprocalForTwoSidedMediaOnly) {
  const Direction a = direction_from_degrees(25, 10), b = direction_from_degrees(65, 130);
  const Direction below = direction_from_degrees(125, 200);
  for (const char* name : {"woven_cloth", "blotchy_layer"}) {
    const Stack stack = load_stack(name);
    EXPECT_TRUE(stack.is_reciprocal());
    const Plan plan = make_plan(stack);
    for (const Direction& w : {b, below})
      EXPECT_LT(std::abs(z_between(at_point(stack, plan, a, w, 40000, 1),
                                   at_point(stack, plan, w, a, 40000, 2))),
                allowed_z())
          << name << ' ' << w.z;
  }
  // Vertical one-sided flakes, denser in some columns: along two ways between the same points the
  // optical depths differ by what the flakes' one side meets.
  EXPECT_FALSE(stack_from(grid_layer("medium = 'vmf_flake'\nroughness = 0.2\nthickness = 1"))
                   .is_reciprocal());
}

TEST(GridWalk, LightPassesColumnsByTheirOwnDepth) {
  // Half the columns are empty, half hold an optical depth of 3: 1/2 + exp(-3) / 2 pass at normal
  // incidence, not exp(-1.5).
  const Stack stack =
      stack_from(grid_layer("medium = 'lambert_sphere'\nthickness = 1\ndensity = 3"));
  const auto voxels =
      shared_voxels_of({16, 4, 16}, [](VoxelIndex i) { return i[0] % 2 == 0 ? 1.0 : 0.0; });
  const RunResult run = run_of(stack, plan_with(stack, {voxels}), direction_from_degrees(0, 0),
                               Estimator::analog, 100000, 1);
  EXPECT_NEAR(run.uncollided[0].value, 0.5 + 0.5 * std::exp(-3.0),
              allowed_z() * run.uncollided[0].standard_error);
}

TEST(GridWalk, LayersKeepTheirRegistrationAcrossGapsAndHomogeneousLayers) {
  // Opaque stripes above, the same ones or the others below: at normal incidence half the light
  // passes, or none; a gap of half the period at 45 degrees exchanges the two.
  const std::string stripes =
      grid_layer("medium = 'lambert_sphere'\nalbedo = 0\nthickness = 1e-4\ndensity = 2e5");
  const auto even = shared_voxels_of({2, 1, 1}, [](VoxelIndex i) { return 1.0 - i[0]; });
  const auto odd = shared_voxels_of({2, 1, 1}, [](VoxelIndex i) { return 1.0 * i[0]; });
  const auto passing = [&](const std::string& between,
                           const std::vector<std::shared_ptr<const Voxels>>& voxels, double theta) {
    const Stack stack = stack_from(stripes + between + stripes);
    return run_of(stack, plan_with(stack, voxels), direction_from_degrees(theta, 0),
                  Estimator::analog, 20000, 1)
        .uncollided[0]
        .value;
  };
  const std::string gap = layer("medium = 'lambert_sphere'\nthickness = 0.5\ndensity = 0");
  const std::string haze = layer("medium = 'lambert_sphere'\nthickness = 0.5\ndensity = 1");
  // Five standard errors of 20000 walks; the stripes' thickness, seen from the side, 1e-3.
  constexpr double kNear = 5 * 0.0035 + 1e-3;
  EXPECT_NEAR(passing("", {even, even}, 0), 0.5, kNear);
  EXPECT_EQ(passing("", {even, odd}, 0), 0);
  EXPECT_NEAR(passing(gap, {even, even}, 45), 0, 1e-3);
  EXPECT_NEAR(passing(gap, {even, odd}, 45), 0.5, kNear);
  EXPECT_NEAR(passing(haze, {even, odd}, 45), 0.5 * std::exp(-0.5 * std::sqrt(2.0)), kNear);
}

TEST(GridWalk, IsTheSameForEveryCutOfSpaceInTheMean) {
  const Stack stack = load_stack("blotchy_layer");
  const Direction wi = direction_from_degrees(60, 0);
  const auto plan = [&](MajorantCells cells) {
    return make_plan(stack, {}, load_grids(stack, cells));
  };
  const auto run = [&](MajorantCells cells, std::uint64_t seed) {
    return run_of(stack, plan(cells), wi, Estimator::analog, 60000, seed);
  };
  const RunResult adaptive = run(MajorantCells::adaptive, 1);
  std::vector<double> z;
  expect_same({{adaptive, run(MajorantCells::global, 2)},
               {run(MajorantCells::adaptive, 4), run(MajorantCells::blocks, 3)}},
              "cells", z);
  expect_normal(z);
}

TEST(GridWalk, IsBitIdenticalForOneTwoAndSevenThreads) {
  const Stack stack = load_stack("settled_dust");
  Plan plan = make_plan(stack);
  const auto sums = [&](int threads, Estimator estimator,
                        const std::vector<std::uint64_t>& checkpoints) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    tbb::task_arena arena(threads);
    return arena.execute([&] {
      Simulation simulation(stack, plan, direction_from_degrees(60, 30), estimator,
                            CellGrid{4, 8, false}, 7);
      for (const std::uint64_t walks : checkpoints) simulation.advance(walks);
      std::vector<double> all;
      for (const BatchTally& b : simulation.batches()) {
        all.insert(all.end(), b.f.begin(), b.f.end());
        for (const auto& order : b.energy.up) all.insert(all.end(), order.begin(), order.end());
        all.insert(all.end(), b.energy.absorbed.begin(), b.energy.absorbed.end());
      }
      return all;
    });
  };
  for (const Isa isa : supported_isas())
    for (const Sampling sampling : {Sampling::random, Sampling::rqmc}) {
      plan.isa = isa;
      plan.sampling = sampling;
      for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
        const auto one = sums(1, estimator, {2000});
        EXPECT_EQ(one, sums(2, estimator, {2000}));
        EXPECT_EQ(one, sums(7, estimator, {100, 1999, 2000}));
      }
    }
}

// Lattices are random shifts: means and standard errors are those of any walks.
TEST(GridWalk, LatticesHaveTheMeansOfRandomNumbers) {
  std::vector<double> z;
  for (const char* name : {"woven_cloth", "settled_dust", "blotchy_layer"}) {
    const Stack stack = load_stack(name);
    const Plan random = make_plan(stack);
    Plan lattices = random;
    lattices.sampling = Sampling::rqmc;
    const Direction wi = direction_from_degrees(55, 30);
    std::vector<std::pair<RunResult, RunResult>> runs;
    for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
      const std::uint64_t walks = estimator == Estimator::analog ? 150000 : 20000;
      runs.emplace_back(run_of(stack, lattices, wi, estimator, walks, 1),
                        run_of(stack, random, wi, estimator, walks, 2));
      EXPECT_EQ(runs.back().first.sampling, Sampling::rqmc);
      EXPECT_EQ(runs.back().second.sampling, Sampling::random);
    }
    expect_same(runs, name, z);
  }
  expect_normal(z);
}

// Order 1 at 16 points with 1e5 walks has 3.3, 3.5 and 2.6 times less variance (lamella bench
// --only grids); with 32768 walks, less; half of the least must be left.
TEST(GridWalk, LatticesTakeNoiseOutOfOrderOne) {
  for (const char* name : {"woven_cloth", "settled_dust", "blotchy_layer"}) {
    const Stack stack = load_stack(name);
    Plan plan = make_plan(stack);
    std::vector<Direction> points;
    for (int k = 0; k < 16; ++k) points.push_back(direction_from_degrees(5.0 * k, 100.0 * k));
    const auto variance = [&](Sampling sampling) {
      plan.sampling = sampling;
      Simulation simulation(stack, plan, direction_from_degrees(55, 30), points, 3);
      simulation.advance(testing::soaked(32768));
      double sum = 0;
      for (std::size_t j = 0; j < points.size(); ++j) {
        const Estimate e =
            batch_estimate(simulation.batches(), [&](const BatchTally& b) { return b.f[j]; });
        sum += e.standard_error * e.standard_error;
      }
      return sum;
    };
    EXPECT_GT(variance(Sampling::random), 1.3 * variance(Sampling::rqmc)) << name;
  }
}

TEST(GridWalk, RefusesLightAlongTheHorizon) {
  const Stack stack = load_stack("blotchy_layer");
  const Plan plan = make_plan(stack);
  EXPECT_THROW(Simulation(stack, plan, direction_from_degrees(90, 0), Estimator::analog,
                          CellGrid{4, 8, false}, 1),
               std::invalid_argument);
  EXPECT_THROW(
      Simulation(stack, plan, direction_from_degrees(0, 0), {direction_from_mu_phi(1e-7, 0)}, 1),
      std::invalid_argument);
  // Near it, walks end.
  for (const Isa isa : supported_isas()) {
    Plan on = plan;
    on.isa = isa;
    const RunResult run =
        run_of(stack, on, direction_from_mu_phi(2e-6, 0.3), Estimator::analog, 500, 1);
    EXPECT_NEAR(ledger_sum(run, 0), 1, 1e-12);
  }
}

TEST(GridWalk, ClosedFormsOfTheStackRefuseAGrid) {
  const Stack stack = load_stack("blotchy_layer");
  EXPECT_THROW((void)stack.uncollided(direction_from_degrees(0, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace lamella
