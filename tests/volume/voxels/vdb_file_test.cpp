#include "volume/voxels/vdb_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "tests/volume/voxels/grids.h"
#include "tests/volume/voxels/vdb_fixture.h"
#include "volume/voxels/sphere_bed_level_set.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using testing::expect_part;
using testing::grid_with;
using testing::VdbFile;

TEST_F(VdbFile, ReadsBackEveryVoxelThatWasWritten) {
  Voxels voxels = testing::voxels_of({19, 8, 11}, [](VoxelIndex i) {
    return testing::scrambled(i) < 0.3 || i[2] > 9 ? 0 : testing::scrambled(i, 1);
  });
  voxels.orientation.emplace(voxels.extent());
  voxels.roughness.emplace(voxels.extent());
  voxels.albedo.emplace(voxels.extent());
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    const auto part = [&](int salt) { return static_cast<float>(testing::scrambled(i, salt)); };
    if (i[0] % 3) voxels.orientation->set(i, {part(2), -part(3), part(4)});
    if (i[1] % 2) voxels.roughness->set(i, {part(5)});
    voxels.albedo->set(i, {part(6), i[0] % 2 ? 1 : part(7), 1});
  });
  write_vdb(file("all.vdb"), voxels, {0.1, 0.2, 0.3});
  const Voxels back = read_vdb(file("all.vdb")).voxels;
  ASSERT_EQ(back.extent(), voxels.extent());  // the empty slice on top among them
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    ASSERT_EQ(back.density.at(i), voxels.density.at(i));
    ASSERT_EQ(back.orientation->at(i), voxels.orientation->at(i));
    ASSERT_EQ(back.roughness->at(i), voxels.roughness->at(i));
    ASSERT_EQ(back.albedo->at(i), voxels.albedo->at(i));
  });
  Voxels plain = testing::voxels_of({8, 8, 8}, [](VoxelIndex) { return 1; });
  write_vdb(file("plain.vdb"), plain, {1, 1, 1});
  const Voxels again = read_vdb(file("plain.vdb")).voxels;
  EXPECT_FALSE(again.orientation || again.roughness || again.albedo);
}

TEST_F(VdbFile, EqualGridsMakeEqualFilesAndOthersDoNot) {
  const auto bytes = [&](const std::string& name, float density) {
    write_vdb(
        file(name),
        testing::voxels_of(
            {9, 8, 8}, [&](VoxelIndex i) { return i[0] < 4 ? density : testing::scrambled(i); }),
        {1, 1, 1});
    std::ifstream stream(file(name), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  const std::string first = bytes("first.vdb", 1);
  EXPECT_EQ(first, bytes("second.vdb", 1));
  // Another identifier, not other voxels alone.
  EXPECT_NE(first.substr(0, 57), bytes("other.vdb", 2).substr(0, 57));
  EXPECT_EQ(read_vdb(file("first.vdb")).voxels.extent().voxels, (VoxelIndex{9, 8, 8}));
}

TEST_F(VdbFile, TakesTheBoxOfActiveVoxelsAndTilesOfOtherToolsFiles) {
  const auto density = openvdb::FloatGrid::create(7.0f);
  density->setName("density");
  density->fill(openvdb::CoordBBox({-16, 5, 100}, {15, 20, 131}), 2.0f);
  density->tree().setValue({-20, 5, 100}, 3.0f);
  density->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
  openvdb::io::File(file("tiles.vdb")).write({density});
  const Voxels voxels = read_vdb(file("tiles.vdb")).voxels;
  ASSERT_EQ(voxels.extent().voxels, (VoxelIndex{36, 16, 32}));
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    const float expected = i == VoxelIndex{0, 0, 0} ? 3 : i[0] >= 4 ? 2 : 7;
    ASSERT_EQ(voxels.density.at(i)[0], expected) << i[0] << ' ' << i[1] << ' ' << i[2];
  });
}

TEST_F(VdbFile, RefusesWhatIsNoFile) {
  expect_part(refusal_of(file("none.vdb")), {"none.vdb", "No such file"});
  std::ofstream(file("text.vdb")) << "no grid at all";
  expect_part(refusal_of(file("text.vdb")), {"text.vdb", "no readable .vdb file"});
  expect_part(refusal_of(fs::path(file("x")).parent_path().string()), {"is a directory"});
}

TEST_F(VdbFile, RefusesMissingEmptyAndMistypedGrids) {
  using openvdb::DoubleGrid, openvdb::FloatGrid, openvdb::Vec3SGrid;
  expect_part(refusal({grid_with<FloatGrid>("smoke", 1)}), {"the grids \"smoke\"", "\"density\""});
  expect_part(refusal({grid_with<DoubleGrid>("density", 1)}),
              {"grid \"density\"", "type double", "float"});
  const auto empty = FloatGrid::create();
  empty->setName("density");
  expect_part(refusal({empty}), {"grid \"density\"", "empty grid"});
  const auto density = grid_with<FloatGrid>("density", 1);
  expect_part(refusal({density, grid_with<FloatGrid>("orientation", 1)}),
              {"grid \"orientation\"", "type float", "vec3s"});
  expect_part(refusal({density, grid_with<Vec3SGrid>("roughness", {1, 1, 1})}),
              {"grid \"roughness\"", "type vec3s", "float"});
  const auto level_set = grid_with<FloatGrid>("density", 1);
  level_set->setGridClass(openvdb::GRID_LEVEL_SET);
  expect_part(refusal({level_set}), {"a level set", "fog volume"});
}

TEST_F(VdbFile, RefusesVoxelsThatAreNoDensitiesAlbedosOrRoughnesses) {
  using openvdb::FloatGrid, openvdb::Vec3SGrid;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {-0.5f, nan, infinity})
    expect_part(refusal({grid_with<FloatGrid>("density", bad)}),
                {"grid \"density\"", "voxel (1, 2, 3)", "0 or more"});
  const auto density = grid_with<FloatGrid>("density", 1);
  expect_part(refusal({density, grid_with<Vec3SGrid>("albedo", {0.5f, 1.5f, 0})}),
              {"grid \"albedo\"", "found 1.5", "voxel (1, 2, 3)", "[0, 1]"});
  expect_part(refusal({density, grid_with<Vec3SGrid>("orientation", {0, nan, 0})}),
              {"grid \"orientation\"", "found nan", "finite"});
  expect_part(refusal({density, grid_with<FloatGrid>("roughness", 0)}),
              {"grid \"roughness\"", "found 0", "(0, 1]"});
}

TEST_F(VdbFile, RefusesTransformsThatTurnAndBoxesBeyondMemory) {
  const auto turned = grid_with<openvdb::FloatGrid>("density", 1);
  const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
  transform->postRotate(0.3, openvdb::math::Z_AXIS);
  turned->setTransform(transform);
  expect_part(refusal({turned}), {"rotates", "scale and translation"});
  const auto wide = grid_with<openvdb::FloatGrid>("density", 1);
  wide->tree().setValue({100000, 100000, 100000}, 1);
  expect_part(refusal({wide}), {"found 100000 x 99999 x 99998 voxels", "2^24 blocks"});
}

TEST(LevelSet, OfOneSphereHasItsVolumeAndArea) {
  const double r = 0.3, volume = 4 * kPi / 3 * r * r * r, area = 4 * kPi * r * r;
  const Vec3<double> centre{0.51, 0.487, 0.5};
  const LevelSetMeasure m = measure_level_set({&centre, 1}, r, 1.0 / 48, {1, 1, 1});
  // The kernels blur the surface by a standard deviation s, s^2 = (1/3 - 2/pi^2) (1.5 voxels)^2:
  // what they see of a ball is the mean over spheres of that spread. Beside that, the midpoint
  // rule.
  const double s2 = (1.0 / 3 - 2 / (kPi * kPi)) * std::pow(1.5 / 48, 2);
  EXPECT_NEAR(m.area_density / area, 1 + s2 / (r * r), 5e-4);
  EXPECT_NEAR(m.volume_fraction / volume, 1 + 3 * s2 / (r * r), 5e-4);
}

TEST(LevelSet, OfPoissonSphereBedsHasTheKnownVolumeAndArea) {
  for (const double packing : {0.05, 0.7}) {
    const SphereBedCheck c = check_sphere_bed(0.02, packing, 8, 8, 1);
    EXPECT_DOUBLE_EQ(c.expected_volume_fraction, 1 - std::exp(-packing));
    EXPECT_NEAR(c.expected_area_density, 3 * packing / 0.02 * std::exp(-packing), 1e-9);
    // Five standard errors of Student's t with 7 degrees of freedom are one chance in 600; beside
    // them the midpoint rule and the creases where spheres meet, below 1 % at 8 voxels per radius.
    EXPECT_NEAR(c.volume_fraction.value, c.blurred_volume_fraction,
                5 * c.volume_fraction.standard_error + 0.01 * c.expected_volume_fraction)
        << packing;
    EXPECT_NEAR(c.area_density.value, c.blurred_area_density,
                5 * c.area_density.standard_error + 0.01 * c.expected_area_density)
        << packing;
  }
}

}  // namespace
}  // namespace lamella
