#include "volume/grid_walk/shadow_rays.h"

#include <gtest/gtest.h>

#include <cmath>

#include "phase/random/random.h"
#include "phase/stack/builtin_stacks.h"
#include "tests/volume/voxels/grids.h"
#include "volume/grid_walk/grid_march.h"

namespace lamella {
namespace {

using testing::allowed_z;
using testing::grid_layer;
using testing::lane_isas;
using testing::plan_with;
using testing::scrambled;
using testing::stack_from;

// sigma_i(w) of a voxel, from the media themselves.
double sigma_in(const DensityGrid& grid, VoxelIndex i, Direction w) {
  const Medium& medium = grid.palette()[grid.palette_index(i)];
  if (!grid.has_orientation()) return sigma(medium, w);
  const double c = dot(grid.axis(i), w), s = std::sqrt(std::max(0.0, 1 - c * c));
  return sigma(medium, {s, 0, c});
}

// The share of light that crosses the grid, by midpoints of 40000 equal steps. A face between
// voxels is misplaced by half a step at most, a hundred faces change an optical depth of 5 by less
// than 1e-3 of the share.
double marched(const DensityGrid& grid, const ShadowRay& ray) {
  constexpr int kSteps = 40000;
  const VoxelIndex n = grid.extent().voxels;
  const Direction h = grid.voxel_size();
  const double thickness = n[2] * h.z;
  const double way = (ray.w.z > 0 ? ray.height : thickness - ray.height) / std::abs(ray.w.z);
  double depth = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double s = way * (k + 0.5) / kSteps;
    const double place[3] = {(ray.x - s * ray.w.x) / h.x, (ray.y - s * ray.w.y) / h.y,
                             (ray.height - s * ray.w.z) / h.z};
    VoxelIndex i;
    for (int a = 0; a < 3; ++a) {
      const double x = a < 2 ? place[a] - n[a] * std::floor(place[a] / n[a]) : place[a];
      i[a] = std::clamp(static_cast<int>(x), 0, n[a] - 1);
    }
    if (grid.density(i) > 0) depth += grid.density(i) * sigma_in(grid, i, ray.w);
  }
  return std::exp(-grid.layer_density() * depth * way / kSteps);
}

// The grids of the test, by what their tables hold: density alone, in many cells or one; turned
// flakes, with and without roughness; two empty halves.
struct GridCase {
  const char* name;
  std::string medium;
  bool turned, rough;
  VoxelIndex voxels;
  double density;
};
std::vector<GridCase> cases() {
  return {
      {"dilute spheres", "medium = 'lambert_sphere'", false, false, {40, 24, 33}, 3},
      {"dense spheres", "medium = 'lambert_sphere'", false, false, {40, 24, 33}, 300},
      {"sggx, not turned", "medium = 'sggx'\nroughness = 0.3", false, false, {9, 16, 5}, 4},
      {"fibers", "medium = 'sggx'\nshape = 'fiber'\nroughness = 0.3", true, false, {24, 24, 17}, 5},
      {"rough flakes", "medium = 'sggx'\nroughness = 0.5", true, true, {17, 33, 24}, 5}};
}

Stack stack_of(const GridCase& c) {
  return stack_from(
      grid_layer(c.medium + "\nthickness = 0.7\ndensity = " + std::to_string(c.density)));
}

Plan plan_of(const GridCase& c, const Stack& stack) {
  // Empty below, denser towards the top, and hollow in one corner.
  Voxels voxels = testing::voxels_of(c.voxels, [&](VoxelIndex i) {
    const bool empty = 3 * i[2] < c.voxels[2] || (i[0] < 8 && i[1] < 8);
    return empty ? 0 : scrambled(i) * i[2] / c.voxels[2];
  });
  if (c.turned) {
    voxels.orientation.emplace(voxels.extent());
    for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
      voxels.orientation->set(
          i, {static_cast<float>(scrambled(i, 1) - 0.3), static_cast<float>(scrambled(i, 2) - 0.6),
              static_cast<float>(scrambled(i, 3))});
    });
  }
  if (c.rough) {
    voxels.roughness.emplace(voxels.extent());
    for_each_voxel(voxels.extent(),
                   [&](VoxelIndex i) { voxels.roughness->set(i, {i[0] % 2 ? 0.2f : 0.9f}); });
  }
  return plan_with(stack, {std::make_shared<const Voxels>(std::move(voxels))});
}

TEST(ShadowRays, TheirMeanIsTheTransmittanceAlongTheRay) {
  const std::uint64_t times = testing::soaked(4000);
  for (const GridCase& c : cases()) {
    const Stack stack = stack_of(c);
    const Plan plan = plan_of(c, stack);
    const DensityGrid& grid = *plan.grids[0];
    const double size = grid.voxel_size().x * c.voxels[0];
    for (const Isa isa : lane_isas()) {
      const ShadowTables tables(isa, plan.grids);
      ASSERT_TRUE(tables.on_lanes()) << c.name;
      RandomStream stream(7, 0, StreamPurpose::test);
      for (int k = 0; k < 12; ++k) {
        // Upwards and down, level with a face, and from the grid's top and bottom themselves.
        Direction w = direction_from_degrees(180 * stream.uniform(), 360 * stream.uniform());
        if (k == 0) w = {0, 0, -1};
        if (k == 1) w = {0.8, 0, 0.6};
        const double height = k == 2 ? 0.7 : k == 3 ? 0 : 0.7 * stream.uniform();
        const ShadowRay ray{size * (3 * stream.uniform() - 1), size * stream.uniform(), height, w};
        if (!ShadowTables::takes(w)) continue;
        ShadowQueue<1> queue(tables, 3);
        std::vector<double> shares(times);
        for (std::uint64_t i = 0; i < times; ++i) {
          queue.begin_walk(i);
          queue.push(grid, ray, {1}, &shares[i], 1);
        }
        queue.flush();
        double sum = 0, sum2 = 0;
        for (const double s : shares) {
          sum += s;
          sum2 += s * s;
        }
        const double n = static_cast<double>(times), mean = sum / n;
        const double error = std::sqrt(std::max(0.0, sum2 / n - mean * mean) / n);
        const double exact = marched(grid, ray);
        // Roulette of small shares has few outcomes, which are large: no normal error.
        if (exact < 1e-3) continue;
        EXPECT_NEAR(mean, exact, allowed_z() * error + 1e-3 * exact)
            << c.name << ' ' << to_text(isa) << ' ' << k;
      }
    }
  }
}

// Against the midpoints of `marched`, within their error; and half of the optical depth leads to a
// place from which the other half leads out, but for rounding.
TEST(FlightByVoxels, SpendsTheOpticalDepthOfItsWay) {
  constexpr double kLarge = 100;
  RandomStream stream(8, 0, StreamPurpose::test);
  for (const GridCase& c : cases()) {
    const Stack stack = stack_of(c);
    const Plan plan = plan_of(c, stack);
    const DensityGrid& grid = *plan.grids[0];
    const double size = grid.voxel_size().x * c.voxels[0];
    const auto fly = [&](const ShadowRay& ray, double& remaining) {
      return std::visit(
          [&]<class M>(const M&) {
            return fly_by_voxels<M>(grid, ray.x, ray.y, ray.height, ray.w, remaining);
          },
          grid.palette()[0]);
    };
    for (int k = 0; k < 12; ++k) {
      Direction w = direction_from_degrees(180 * stream.uniform(), 360 * stream.uniform());
      if (k == 0) w = {0, 0, -1};
      if (k == 1) w = {0.8, 0, 0.6};
      const ShadowRay ray{size * (3 * stream.uniform() - 1), size * stream.uniform(),
                          0.7 * stream.uniform(), w};
      double left = kLarge;
      const GridFlight through = fly(ray, left);
      const double exact = marched(grid, ray), depth = kLarge - left;
      if (exact < 1e-3) continue;  // the error of `marched` is that of an optical depth of 5
      EXPECT_EQ(through.end, Flight::left) << c.name << ' ' << k;
      EXPECT_NEAR(std::exp(-depth), exact, 1e-3 * exact) << c.name << ' ' << k;
      if (depth < 1e-3) continue;
      double half = depth / 2;
      const GridFlight first = fly(ray, half);
      ASSERT_EQ(first.end, Flight::collided) << c.name << ' ' << k;
      EXPECT_GT(grid.density(first.voxel), 0);
      ShadowRay rest = ray;
      rest.x -= w.x * first.length;
      rest.y -= w.y * first.length;
      rest.height -= w.z * first.length;
      double after = kLarge;
      EXPECT_EQ(fly(rest, after).end, Flight::left);
      EXPECT_NEAR(kLarge - after, depth / 2, 1e-9 * kLarge) << c.name << ' ' << k;
    }
  }
}

TEST(ShadowRays, SumsDoNotDependOnCheckpoints) {
  const Stack stack = load_stack("woven_cloth");
  Plan plan = make_plan(stack);
  for (const Isa isa : lane_isas()) {
    plan.isa = isa;
    const Direction wi = direction_from_degrees(55, 30);
    const auto make = [&] {
      return std::make_unique<Simulation>(stack, plan, wi, Estimator::next_event,
                                          CellGrid{4, 8, false}, 1);
    };
    const auto at_once = make(), by_parts = make();
    at_once->advance(kBatches * 9);
    for (const int walks : {1, 4, 9}) by_parts->advance(kBatches * walks);
    for (int b = 0; b < kBatches; ++b)
      EXPECT_EQ(at_once->batches()[b].f, by_parts->batches()[b].f) << to_text(isa) << ' ' << b;
  }
}

TEST(ShadowRays, CrossHomogeneousLayersAndSecondGridsOnTheirWayOut) {
  const std::string spheres = "medium = 'lambert_sphere'\nthickness = 0.4\ndensity = 2";
  const std::string clear = testing::layer("medium = 'henyey_greenstein'\nthickness = 0.3");
  const auto voxels =
      testing::shared_voxels_of({16, 16, 8}, [](VoxelIndex i) { return 2 * scrambled(i); });
  for (const std::string& text :
       {clear + grid_layer(spheres) + clear, grid_layer(spheres) + clear + grid_layer(spheres)}) {
    const Stack stack = stack_from(text);
    Plan plan = plan_with(stack, {voxels, voxels});
    // One way near the horizon, which lanes leave to double.
    const std::vector<Direction> points{direction_from_degrees(20, 40),
                                        direction_from_degrees(89.97, 200),
                                        direction_from_degrees(130, 10)};
    const auto value = [&](Isa isa, int point, std::uint64_t seed) {
      plan.isa = isa;
      Simulation simulation(stack, plan, direction_from_degrees(40, 0), points, seed);
      simulation.advance(testing::soaked(20000));
      return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
        double f = 0;
        for (int o = 0; o < kTallyOrders; ++o) f += b.f[o * points.size() + point];
        return f;
      });
    };
    for (int point = 0; point < 3; ++point) {
      const Estimate scalar = value(Isa::scalar, point, 1);
      for (const Isa isa : lane_isas())
        EXPECT_LT(std::abs(testing::z_between(value(isa, point, 2), scalar)), allowed_z())
            << to_text(isa) << ' ' << point;
    }
  }
}

TEST(ShadowRays, AreScalarWhereLanesHaveNoTable) {
  const auto grids_of = [](const std::string& medium, bool turned) {
    const Stack stack = stack_from(grid_layer(medium + "\nroughness = 0.5\nthickness = 1"));
    Voxels voxels = testing::voxels_of({4, 4, 4}, [](VoxelIndex) { return 1.0; });
    if (turned) {
      voxels.orientation.emplace(voxels.extent());
      voxels.orientation->fill({0, 0, 0}, {4, 4, 4}, {1, 2, 3});
    } else {
      voxels.roughness.emplace(voxels.extent());
      voxels.roughness->fill({0, 0, 0}, {4, 4, 2}, {0.25f});
    }
    return plan_with(stack, {std::make_shared<const Voxels>(std::move(voxels))}).grids;
  };
  for (const Isa isa : lane_isas()) {
    EXPECT_FALSE(ShadowTables(isa, grids_of("medium = 'vmf_flake'", true)).on_lanes());
    EXPECT_FALSE(ShadowTables(isa, grids_of("medium = 'sggx'", false)).on_lanes());
    EXPECT_TRUE(ShadowTables(isa, grids_of("medium = 'sggx'", true)).on_lanes());
  }
  EXPECT_FALSE(ShadowTables(Isa::scalar, grids_of("medium = 'sggx'", true)).on_lanes());
}

}  // namespace
}  // namespace lamella
