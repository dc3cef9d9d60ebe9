#include "volume/voxels/density_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "phase/stack/builtin_stacks.h"
#include "tests/volume/voxels/grids.h"
#include "volume/grid_walk/grid_march.h"
#include "volume/grid_walk/grid_stack.h"
#include "volume/voxels/depth_profile.h"
#include "volume/voxels/grid_generators.h"

namespace lamella {
namespace {

using testing::grid_layer;
using testing::scrambled;
using testing::stack_from;

constexpr const char* kFiber = "medium = 'sggx'\nshape = 'fiber'\nroughness = 0.2\nthickness = 0.7";

Direction any_direction(int k) {
  RandomStream stream(11, k, StreamPurpose::test);
  const double u1 = stream.uniform(), u2 = stream.uniform();
  return uniform_sphere(u1, u2);
}

TEST(VoxelField, HoldsWhatWasSetAndStoresUniformBlocksOnce) {
  VoxelField<1> field(VoxelExtent{{20, 9, 8}});
  field.fill({0, 0, 0}, {20, 9, 8}, {3});
  EXPECT_TRUE(field.is_uniform({17, 8, 3}));
  field.fill({4, 4, 4}, {12, 9, 6}, {5});
  field.set({19, 8, 7}, {7});
  for_each_voxel(field.extent(), [&](VoxelIndex i) {
    const bool inside = i[0] >= 4 && i[0] < 12 && i[1] >= 4 && i[2] >= 4 && i[2] < 6;
    const float expected = i == VoxelIndex{19, 8, 7} ? 7 : inside ? 5 : 3;
    ASSERT_EQ(field.at(i)[0], expected) << i[0] << ' ' << i[1] << ' ' << i[2];
  });
  EXPECT_FALSE(field.is_uniform({17, 8, 3}));
  EXPECT_TRUE(field.is_uniform({17, 3, 3}));
}

// Patches of density and axis, with a few voxels apart from their neighbours.
std::shared_ptr<const Voxels> varied_voxels(bool orientation, bool roughness) {
  Voxels voxels = testing::voxels_of({40, 24, 19}, [](VoxelIndex i) {
    return i[0] < 12 || scrambled(i) < 0.4 ? 0 : scrambled(i, 1) * (i[2] < 9 ? 1 : 5);
  });
  if (orientation) voxels.orientation.emplace(voxels.extent());
  if (roughness) voxels.roughness.emplace(voxels.extent());
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    // Narrow cones, wide ones, opposite signs, and voxels that leave it to the layer.
    const double spread = i[0] < 24 ? 0.05 : 2;
    const auto part = [&](int salt) {
      return static_cast<float>(spread * (scrambled(i, salt) - 0.5));
    };
    const float sign = scrambled(i, 5) < 0.5 ? -1 : 1;
    if (orientation && i[1] != 3)
      voxels.orientation->set(i, {sign * (1 + part(2)), sign * part(3), sign * part(4)});
    if (roughness && i[1] != 4)
      voxels.roughness->set(i, {static_cast<float>(0.05 + 0.1 * std::floor(9 * scrambled(i, 6)))});
  });
  return std::make_shared<const Voxels>(std::move(voxels));
}

template <class M>
void check_bounds(const DensityGrid& grid, const std::string& what) {
  for (int k = 0; k < 4; ++k) {
    const Direction w = any_direction(k);
    for_each_voxel(grid.extent(), [&](VoxelIndex i) {
      if (!(grid.density(i) > 0)) return;
      const MajorantCell& cell = grid.cell(i);
      const double content = grid.density(i) * grid.sigma<M>(i, w);
      ASSERT_LE(content, cell.density * grid.sigma_bound<M>(i, cell, w) * (1 + 1e-12))
          << what << ' ' << i[0] << ' ' << i[1] << ' ' << i[2];
    });
  }
}

TEST(Majorants, BoundEveryVoxelOfTheirCellInEveryDirection) {
  for (const MajorantCells cells :
       {MajorantCells::blocks, MajorantCells::adaptive, MajorantCells::global})
    for (const bool orientation : {false, true})
      for (const bool roughness : {false, true}) {
        const auto voxels = varied_voxels(orientation, roughness);
        const auto grid_of = [&](const std::string& keys) {
          return DensityGrid(stack_from(grid_layer(keys)).layers[0], voxels, cells);
        };
        check_bounds<MirrorFlakes<Sggx>>(grid_of(kFiber), "fiber");
        check_bounds<MirrorFlakes<Sggx>>(
            grid_of("medium = 'sggx'\nroughness = 0.1\naxis = [1, 2, 0]\nthickness = 1"),
            "surface");
        check_bounds<LambertFlakes<Vmf>>(
            grid_of("medium = 'vmf_flake'\nroughness = 0.3\nthickness = 1"), "vmf");
      }
}

TEST(Majorants, AreTheLargestVoxelWhereTheMediumDoesNotVary) {
  const auto voxels = varied_voxels(false, false);
  const Layer layer = stack_from(grid_layer(kFiber)).layers[0];
  for (const MajorantCells kind :
       {MajorantCells::blocks, MajorantCells::adaptive, MajorantCells::global}) {
    const DensityGrid grid(layer, voxels, kind);
    std::size_t cells = 0;
    const VoxelIndex n = grid.extent().voxels;
    for_each_voxel(grid.extent(), [&](VoxelIndex first) {
      const int size = kBlockVoxels << grid.cell(first).level;
      for (int a = 0; a < 3; ++a)
        if (first[a] % size != 0) return;
      ++cells;
      double largest = 0;
      VoxelIndex i;
      for (i[2] = first[2]; i[2] < std::min(n[2], first[2] + size); ++i[2])
        for (i[1] = first[1]; i[1] < std::min(n[1], first[1] + size); ++i[1])
          for (i[0] = first[0]; i[0] < std::min(n[0], first[0] + size); ++i[0]) {
            ASSERT_EQ(grid.cell(i).level, grid.cell(first).level);
            ASSERT_EQ(grid.cell(i).density, grid.cell(first).density);
            largest = std::max(largest, grid.density(i));
          }
      EXPECT_EQ(grid.cell(first).density, largest);
    });
    EXPECT_EQ(cells, grid.count_cells().cells);
    if (kind == MajorantCells::global) {
      EXPECT_EQ(cells, 1u);
    }
  }
}

// The way from a place out of the grid, voxel by voxel of a midpoint rule: optical depth.
template <class M>
double optical_depth_by_steps(const DensityGrid& grid, double x, double y, double height,
                              Direction w) {
  const VoxelIndex n = grid.extent().voxels;
  const Direction h = grid.voxel_size();
  const double thickness = h.z * n[2];
  const double length = (w.z > 0 ? height : thickness - height) / std::abs(w.z);
  constexpr int kSteps = 40000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double s = (k + 0.5) / kSteps * length;
    const double p[3] = {(x - s * w.x) / h.x, (y - s * w.y) / h.y, (height - s * w.z) / h.z};
    VoxelIndex i;
    for (int a = 0; a < 3; ++a) {
      i[a] = static_cast<int>(std::floor(p[a]));
      if (a < 2) i[a] = ((i[a] % n[a]) + n[a]) % n[a];
      i[a] = std::clamp(i[a], 0, n[a] - 1);
    }
    if (grid.density(i) > 0) sum += grid.density(i) * grid.sigma<M>(i, w) * length / kSteps;
  }
  return grid.layer_density() * sum;
}

TEST(GridMarch, DeltaAndRatioTrackingHaveTheTransmittanceOfTheWay) {
  const auto voxels = varied_voxels(true, true);
  const Layer layer =
      stack_from(grid_layer(std::string(kFiber) + "\ndensity = 1.5", 1.3, 0.8)).layers[0];
  using M = MirrorFlakes<Sggx>;
  for (const MajorantCells kind : {MajorantCells::adaptive, MajorantCells::global}) {
    const DensityGrid grid(layer, voxels, kind);
    for (int k = 0; k < 6; ++k) {
      Direction w = any_direction(20 + k);
      w.z = std::copysign(std::max(0.15, std::abs(w.z)), w.z);
      w = normalized(w);
      const double x = 0.3 + k, y = -2.1 * k, height = 0.1 + 0.09 * k;
      const double exact = std::exp(-optical_depth_by_steps<M>(grid, x, y, height, w));
      const int walks = 20000;
      std::vector<double> left, ratio;
      for (int j = 0; j < walks; ++j) {
        RandomStream stream(3 + k, j, StreamPurpose::test);
        double remaining = stream.exponential();
        const GridFlight flight = fly<M>(grid, x, y, height, w, remaining, stream);
        left.push_back(flight.end == Flight::left);
        ratio.push_back(ratio_tracked<M>(grid, x, y, height, w, stream));
      }
      // The midpoint rule is off by a step at each face it crosses: far below the noise.
      EXPECT_GT(testing::mean_p_value(left, exact), testing::test_level()) << k << ' ' << exact;
      EXPECT_GT(testing::mean_p_value(ratio, exact), testing::test_level()) << k << ' ' << exact;
    }
  }
}

TEST(GridMarch, CrossesEmptySpaceInFewStepsAndComesOutWhereItShould) {
  // One dense block in a tile of 64^3: every other voxel is empty.
  const auto voxels = testing::shared_voxels_of(
      {64, 64, 64}, [](VoxelIndex i) { return i[0] < 8 && i[1] < 8 && i[2] >= 56 ? 1.0 : 0.0; });
  const DensityGrid grid(stack_from(grid_layer(kFiber)).layers[0], voxels);
  const Direction d = normalized(Direction{0.3, 0.4, -1});
  GridMarch march(grid, 0.5, 0.5, 0.7, d);
  int cells = 1;
  for (; march.next(); ++cells) EXPECT_EQ(march.cell().density, 0);
  EXPECT_LT(cells, 12);  // of 8 at least that lie on the way as blocks
  EXPECT_NEAR(march.before() + march.length(), 0.7 / -d.z, 1e-12);
}

TEST(GridMarch, LevelWaysAlongEmptySlabsEnd) {
  // Empty but for the lowest slice: a cell as wide as the tile has no sides.
  const auto voxels =
      testing::shared_voxels_of({16, 16, 64}, [](VoxelIndex i) { return i[2] < 8 ? 1.0 : 0.0; });
  const DensityGrid grid(stack_from(grid_layer(kFiber)).layers[0], voxels);
  GridMarch march(grid, 0.2, 0.2, 0.7, normalized(Direction{1, 0, -1e-6}));
  int cells = 0;
  while (march.cell().density == 0 && march.next()) ++cells;
  EXPECT_LT(cells, 8);
  EXPECT_GT(march.cell().density, 0);
}

TEST(GridPeriods, HaveACommonTileOrAreRefused) {
  EXPECT_DOUBLE_EQ(common_period({1}), 1);
  EXPECT_DOUBLE_EQ(common_period({0.5, 0.75}), 1.5);
  EXPECT_DOUBLE_EQ(common_period({1, 0.1, 0.25}), 1);
  EXPECT_THROW((void)common_period({1, std::sqrt(2.0)}), std::invalid_argument);
}

TEST(DensityGrid, RefusesWhatTheMediumCannotTake) {
  const auto message = [](const std::string& keys, bool orientation, bool roughness) {
    try {
      const DensityGrid grid(stack_from(grid_layer(keys)).layers[0],
                             varied_voxels(orientation, roughness));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string matrix = "medium = 'sggx'\nmatrix = [1, 1, 0.5, 0, 0, 0]\nthickness = 1";
  EXPECT_NE(message(matrix, true, false)
                .find("test:5: layer 0: key \"grid\": test.vdb: found a "
                      "grid \"orientation\""),
            std::string::npos)
      << message(matrix, true, false);
  EXPECT_NE(message(matrix, false, true).find("\"roughness\""), std::string::npos);
  EXPECT_NE(message("medium = 'lambert_sphere'\nthickness = 1", false, true).find("\"roughness\""),
            std::string::npos);
  // An axis does not matter to particles.
  EXPECT_EQ(message("medium = 'lambert_sphere'\nthickness = 1", true, false), "");
}

TEST(DepthProfile, HasTheMeansOfTheSlicesAndJoinsEqualOnes) {
  const Stack stack = stack_from(
      grid_layer("medium = 'henyey_greenstein'\nalbedo = 0.5\nthickness = 2\ndensity = 3"));
  // From below: two slices of mean 1 (one uneven), then one of 0, one of 2.
  const auto voxels = testing::shared_voxels_of({2, 2, 4}, [](VoxelIndex i) {
    return i[2] == 0 ? 1.0 : i[2] == 1 ? 2.0 * (i[0] == 0) : i[2] == 2 ? 0.0 : 2.0;
  });
  const Plan plan = testing::plan_with(stack, {voxels});
  const Stack layers = homogenised(stack, plan.grids);
  ASSERT_EQ(layers.layers.size(), 3u);
  const double density[] = {6, 0, 3}, thickness[] = {0.5, 0.5, 1};
  for (int k = 0; k < 3; ++k) {
    EXPECT_DOUBLE_EQ(layers.layers[k].density, density[k]);
    EXPECT_DOUBLE_EQ(layers.layers[k].thickness, thickness[k]);
    EXPECT_FALSE(layers.layers[k].grid);
  }
  const LateralContrast contrast = lateral_contrast(*plan.grids[0]);
  EXPECT_DOUBLE_EQ(contrast.voxel, 0.5);  // mean square 1/4 over a mean of 1
  EXPECT_DOUBLE_EQ(contrast.column, 0.25);
  EXPECT_DOUBLE_EQ(contrast.filled, 10.0 / 16);
}

TEST(DepthProfile, AveragesFlakesAndAlbedoByTheirDensity) {
  const Stack stack = stack_from(grid_layer(std::string(kFiber) + "\nalbedo = 0.8"));
  Voxels voxels = testing::voxels_of({2, 1, 1}, [](VoxelIndex i) { return i[0] == 0 ? 3 : 1; });
  voxels.orientation.emplace(voxels.extent());
  voxels.orientation->set({0, 0, 0}, {2, 0, 0});
  voxels.orientation->set({1, 0, 0}, {0, -1, 0});
  voxels.albedo.emplace(voxels.extent());
  voxels.albedo->set({0, 0, 0}, {1, 1, 1});
  voxels.albedo->set({1, 0, 0}, {0, 0.5, 1});
  const Plan plan = testing::plan_with(stack, {std::make_shared<const Voxels>(std::move(voxels))});
  EXPECT_EQ(plan.channels, 3);
  const Layer layer = homogenised(stack, plan.grids).layers.at(0);
  // S of fibers along x: diag(0.04, 1, 1); along y: diag(1, 0.04, 1).
  const auto& matrix = std::get<std::vector<double>>(layer.parameters.at("matrix"));
  EXPECT_NEAR(matrix[0], 0.75 * 0.04 + 0.25, 1e-12);
  EXPECT_NEAR(matrix[1], 0.75 + 0.25 * 0.04, 1e-12);
  EXPECT_NEAR(matrix[2], 1, 1e-12);
  EXPECT_NEAR(layer.albedo.r, 0.8 * 0.75, 1e-12);
  EXPECT_NEAR(layer.albedo.g, 0.8 * 0.875, 1e-12);
  EXPECT_NEAR(layer.albedo.b, 0.8, 1e-12);
}

TEST(GridGenerators, MakePeriodicTilesOfWhatTheySay) {
  for (const GridGenerator& generator : grid_generators()) {
    Parameters parameters;
    fill_defaults(generator.parameters, parameters);
    const GeneratedGrid made = generator.make(parameters);
    const Stack stack =
        stack_from("[[layer]]\n" + made.medium + "thickness = " + std::to_string(made.thickness) +
                   "\ngrid = 'test.vdb'\nsize = [1, 1]\n");
    const DensityGrid grid(stack.layers[0], std::make_shared<Voxels>(made.voxels));
    const LateralContrast contrast = lateral_contrast(grid);
    EXPECT_GT(contrast.voxel, 0.2) << generator.name;
    EXPECT_GT(contrast.filled, 0.2) << generator.name;
    // Across the seam of the tile, neighbours differ no more than elsewhere.
    const VoxelIndex n = grid.extent().voxels;
    for (int a = 0; a < 2; ++a) {
      double seam = 0, inside = 0;
      for_each_voxel(grid.extent(), [&](VoxelIndex i) {
        VoxelIndex next = i;
        next[a] = (i[a] + 1) % n[a];
        const double d = std::abs(grid.density(i) - grid.density(next));
        (next[a] == 0 ? seam : inside) += d / (next[a] == 0 ? 1 : n[a] - 1);
      });
      EXPECT_LT(seam, 3 * inside) << generator.name << ' ' << a;
    }
  }
}

TEST(GridGenerators, WeaveTheFibersAlongTheYarns) {
  Parameters parameters;
  const GridGenerator& weave = *find_grid_generator("weave");
  parameters.set("twist", 0.0);
  fill_defaults(weave.parameters, parameters);
  const GeneratedGrid made = weave.make(parameters);
  // Where a yarn passes over another its core is level and runs along x or y.
  const VoxelIndex n = made.voxels.extent().voxels;
  const int quarter = n[0] / 4;
  const auto top = made.voxels.orientation->at({quarter, quarter, 3 * n[2] / 4});
  const auto bottom = made.voxels.orientation->at({quarter, quarter, n[2] / 4});
  EXPECT_GT(std::abs(top[0] * bottom[1] - top[1] * bottom[0]), 0.99);
  EXPECT_LT(std::abs(top[2]), 0.15);  // half a voxel off the crossing
}

TEST(BuiltinGrids, HaveTheThicknessAndPeriodOfTheirStacks) {
  for (const auto& [stack_name, kind] : {std::pair{"woven_cloth", "weave"},
                                         {"settled_dust", "dust"},
                                         {"blotchy_layer", "blotches"}}) {
    Parameters parameters;
    fill_defaults(find_grid_generator(kind)->parameters, parameters);
    const GeneratedGrid made = find_grid_generator(kind)->make(parameters);
    const Layer layer = load_stack(stack_name).layers[0];
    EXPECT_EQ(layer.thickness, made.thickness);
    EXPECT_EQ(layer.grid->size_x, made.size_x);
    EXPECT_EQ(layer.grid->size_y, made.size_y);
  }
}

}  // namespace
}  // namespace lamella
