// Counted walks through grids on lanes, against the same walks in double and against homogeneous
// layers.

#include <gtest/gtest.h>

#include <cmath>

#include "phase/medium/media.h"
#include "phase/random/random.h"
#include "phase/stack/builtin_stacks.h"
#include "tests/volume/grid_walk/agreement.h"
#include "volume/grid_walk/turned_flakes.h"

namespace lamella {
namespace {

using testing::expect_normal;
using testing::expect_same;
using testing::grid_layer;
using testing::lane_isas;
using testing::layer;
using testing::plan_with;
using testing::run_of;
using testing::scrambled;
using testing::shared_voxels_of;
using testing::stack_from;

// sigma is that of the flakes, and with it S, which is all that visible normals depend on.
TEST(TurnedFlakes, HaveTheAreasOfTheirRecord) {
  RandomStream stream(1, 0, StreamPurpose::test);
  const auto direction = [&] {
    const double u = stream.uniform(), v = stream.uniform();
    return uniform_sphere(u, v);
  };
  for (const double along : {0.05, 0.3, 1.0, 1.7}) {
    const double across = along < 1 ? 1 : 0.4, rho = 1e-6 + stream.uniform();
    const Direction axis = direction();
    const double difference = along * along - across * across;
    const Direction v = rho * std::sqrt(std::abs(difference)) * axis;
    const auto a = turned_flakes(rho * rho * across * across, v, difference > 0 ? 1.0 : -1.0);
    for (int k = 0; k < 20; ++k) {
      const Direction w = direction();
      const double c = dot(w, axis);
      const double sigma = std::sqrt(along * along * c * c + across * across * (1 - c * c));
      EXPECT_NEAR(across * length(a.apply_transposed(w)), sigma, 1e-12);
    }
  }
}

// Grids of every kind that lanes take.
struct LaneGridCase {
  std::string name;
  Stack stack;
  std::shared_ptr<const Voxels> voxels;  // none: the stack's own
};

std::shared_ptr<const Voxels> hollow(VoxelIndex n, bool turned, bool rough) {
  Voxels voxels = testing::voxels_of(n, [&](VoxelIndex i) {
    return i[0] < 8 && i[1] < 8 ? 0 : (0.2 + scrambled(i)) * (i[2] + 1) / n[2];
  });
  if (turned) {
    voxels.orientation.emplace(voxels.extent());
    for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
      voxels.orientation->set(
          i, {static_cast<float>(scrambled(i, 1) - 0.3), static_cast<float>(scrambled(i, 2) - 0.6),
              static_cast<float>(scrambled(i, 3))});
    });
  }
  if (rough) {
    voxels.roughness.emplace(voxels.extent());
    for_each_voxel(voxels.extent(),
                   [&](VoxelIndex i) { voxels.roughness->set(i, {i[0] % 2 ? 0.2f : 0.9f}); });
  }
  return std::make_shared<const Voxels>(std::move(voxels));
}

std::vector<LaneGridCase> lane_grid_cases() {
  const auto of = [](const std::string& keys, const std::string& below = {}) {
    return stack_from(grid_layer(keys + "\nthickness = 0.7") + below);
  };
  const std::string base = "[substrate]\nalbedo = [0.5, 0.9, 0.1]\n";
  std::vector<LaneGridCase> cases;
  for (const char* name : {"woven_cloth", "settled_dust", "blotchy_layer"})
    cases.push_back({name, load_stack(name), nullptr});
  cases.push_back({"colour over a substrate, in many cells",
                   of("medium = 'rayleigh'\nalbedo = [0.9, 0.5, 0.7]\ndensity = 40", base),
                   hollow({40, 24, 33}, false, false)});
  cases.push_back({"rough flakes, turned, that mirror by Schlick's rule",
                   of("medium = 'sggx'\nroughness = 0.5\nf0 = [0.04, 0.3, 1]\ndensity = 6"),
                   hollow({17, 33, 24}, true, true)});
  cases.push_back(
      {"Lambertian fibers, turned",
       of("medium = 'sggx'\nshape = 'fiber'\nroughness = 0.2\nflake = 'lambert'\nalbedo = 0.8\n"
          "density = 5"),
       hollow({24, 24, 17}, true, false)});
  cases.push_back({"flakes of one side, not turned",
                   of("medium = 'vmf_flake'\nroughness = 0.5\nalbedo = 0.9\ndensity = 5"),
                   hollow({9, 16, 5}, false, false)});
  return cases;
}

Plan plan_through(const LaneGridCase& c) {
  return c.voxels ? plan_with(c.stack, {c.voxels}) : make_plan(c.stack);
}

TEST(GridLanes, AgreeWithWalksInDouble) {
  std::vector<double> z;
  for (const LaneGridCase& c : lane_grid_cases()) {
    Plan plan = plan_through(c);
    std::vector<RunResult> scalar;
    std::vector<Direction> light;
    for (const double theta : {55.0, 130.0})
      if (theta < 90 || c.stack.is_open_below()) light.push_back(direction_from_degrees(theta, 25));
    for (const Direction wi : light)
      scalar.push_back(run_of(c.stack, plan, wi, Estimator::analog, 60000, 1));
    for (const Isa isa : lane_isas())
      for (const Sampling sampling : {Sampling::random, Sampling::rqmc}) {
        plan.isa = isa;
        plan.sampling = sampling;
        std::vector<std::pair<RunResult, RunResult>> runs;
        for (std::size_t k = 0; k < light.size(); ++k) {
          const std::uint64_t seed = 2 + 2 * static_cast<std::uint64_t>(isa);
          Simulation lanes(c.stack, plan, light[k], Estimator::analog, CellGrid{4, 8, false},
                           seed + (sampling == Sampling::rqmc));
          EXPECT_EQ(lanes.isa(), isa) << c.name;
          lanes.advance(testing::soaked(60000));
          runs.emplace_back(reduce(lanes), scalar[k]);
          EXPECT_NEAR(ledger_sum(runs.back().first, 0), 1, 1e-12);
        }
        std::vector<double> of_case;
        expect_same(runs, c.name + ", " + to_text(isa), of_case);
        // Others share the scalar run, and so depend on each other.
        if (isa == lane_isas().back() && sampling == Sampling::random)
          z.insert(z.end(), of_case.begin(), of_case.end());
      }
  }
  expect_normal(z);
}

TEST(GridLanes, ThroughAConstantGridAreThoseThroughTheHomogeneousLayer) {
  std::vector<double> z;
  for (const std::string& medium : testing::every_medium()) {
    const std::string keys = medium + "\nalbedo = 0.8\nthickness = 0.5\ndensity = ";
    const Stack grid = stack_from(grid_layer(keys + "4")), layers = stack_from(layer(keys + "2"));
    Plan plan = plan_with(grid, {shared_voxels_of({9, 16, 5}, [](VoxelIndex) { return 0.5; })});
    Plan homogeneous = make_plan(layers);
    homogeneous.folded = false;
    const Direction wi = direction_from_degrees(50, 25);
    const RunResult truth = run_of(layers, homogeneous, wi, Estimator::analog, 40000, 2);
    plan.isa = lane_isas().back();
    expect_same({{run_of(grid, plan, wi, Estimator::analog, 40000, 1), truth}}, medium, z);
  }
  expect_normal(z);
}

TEST(GridLanes, LeaveToDoubleWhatTheyDoNotTake) {
  const auto isa_of = [](const Stack& stack, Plan plan) {
    plan.isa = lane_isas().back();
    return Simulation(stack, plan, {0, 0, 1}, Estimator::analog, CellGrid{2, 2, false}, 1).isa();
  };
  const auto of = [&](const std::string& keys, bool turned, const std::string& more = {}) {
    const Stack stack = stack_from(grid_layer(keys + "\nthickness = 1") + more);
    return isa_of(stack, plan_with(stack, {hollow({9, 9, 9}, turned, false)}));
  };
  const std::string fiber = "medium = 'sggx'\nshape = 'fiber'\nroughness = ";
  EXPECT_EQ(of(fiber + "0.1", true), lane_isas().back());
  EXPECT_EQ(of(fiber + "0.01", true), Isa::scalar);
  EXPECT_EQ(of("medium = 'vmf_flake'\nroughness = 0.5", true), Isa::scalar);
  EXPECT_EQ(of("medium = 'rayleigh'\ndensity = 1e5", false), Isa::scalar);
  EXPECT_EQ(of("medium = 'rayleigh'", false, layer("medium = 'rayleigh'\nthickness = 1")),
            Isa::scalar);
}

}  // namespace
}  // namespace lamella
