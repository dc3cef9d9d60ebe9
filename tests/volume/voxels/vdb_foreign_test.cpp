// .vdb files as other programs write them: places, sizes, names, backgrounds.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <fstream>

#include "tests/volume/voxels/vdb_fixture.h"
#include "volume/voxels/vdb_file.h"

namespace lamella {
namespace {

using testing::expect_part;
using testing::grid_with;
using testing::VdbFile;

using testing::from_array;
using testing::full_density;
using testing::stripe;
using testing::write;
using Transform = openvdb::math::Transform;

VdbRequest of_size(double x, double y, double z) {
  VdbRequest request;
  request.size = Vec3<double>{x, y, z};
  return request;
}

TEST_F(VdbFile, TakesGridsOfOtherVoxelsWhereTheyLieInSpace) {
  const auto density = full_density();
  const auto coarse = [](VoxelIndex j) {
    return openvdb::Vec3s(0.1f + 0.1f * static_cast<float>(j[0]),
                          0.1f + 0.1f * static_cast<float>(j[1]),
                          0.1f + 0.2f * static_cast<float>(j[2]));
  };
  const auto albedo = from_array<openvdb::Vec3SGrid>("albedo", {8, 8, 4}, 1.0 / 8, coarse);
  const auto expect_doubled = [&](const Voxels& voxels, const char* what) {
    for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
      const openvdb::Vec3s value = coarse({i[0] / 2, i[1] / 2, i[2] / 2});
      for (int k = 0; k < 3; ++k)
        ASSERT_EQ(voxels.albedo->at(i)[k], value[k]) << what << i[0] << ' ' << i[1] << ' ' << i[2];
    });
  };
  // Both arrays scaled by their voxel size: index 0 is a corner.
  write(file("corners.vdb"), {density, albedo});
  expect_doubled(read_vdb(file("corners.vdb")).voxels, "corners ");
  // Both moved by half of their voxels: index 0 is the middle of a voxel, as for Blender.
  const auto moved = [](auto& grid, double half) {
    const auto transform = Transform::createLinearTransform(2 * half);
    transform->postTranslate({half, half, half});
    grid.setTransform(transform);
  };
  moved(*density, 1.0 / 32);
  moved(*albedo, 1.0 / 16);
  write(file("middles.vdb"), {density, albedo});
  expect_doubled(read_vdb(file("middles.vdb")).voxels, "middles ");
}

TEST_F(VdbFile, TakesGridsOfFinerVoxelsAtTheMiddlesAndSaysSo) {
  const auto albedo = from_array<openvdb::Vec3SGrid>(
      "albedo", {48, 48, 24}, 1.0 / 48,
      [](VoxelIndex j) { return openvdb::Vec3s(static_cast<float>(j[0] + 1) / 48, 0.5f, 0.5f); });
  write(file("fine.vdb"), {full_density(), albedo});
  const VdbGrids grids = read_vdb(file("fine.vdb"));
  ASSERT_EQ(grids.warnings.size(), 1u);
  EXPECT_NE(grids.warnings[0].find("smaller than the density's"), std::string::npos);
  for_each_voxel(grids.voxels.extent(), [&](VoxelIndex i) {
    ASSERT_EQ(grids.voxels.albedo->at(i)[0], static_cast<float>(3 * i[0] + 2) / 48) << i[0];
  });
}

TEST_F(VdbFile, TakesGridsThatLieElsewhereAndTheirBackgroundBeyond) {
  // The right half of the tile, an array of its own that begins at index 0.
  const auto roughness = from_array<openvdb::FloatGrid>(
      "roughness", {8, 16, 8}, 1.0 / 16, [](VoxelIndex j) { return j[0] < 4 ? 0.25f : 0.75f; });
  const auto transform = Transform::createLinearTransform(1.0 / 16);
  transform->postTranslate({0.5, 0, 0});
  roughness->setTransform(transform);
  const auto albedo = from_array<openvdb::Vec3SGrid>(
      "albedo", {8, 16, 8}, 1.0 / 16, [](VoxelIndex) { return openvdb::Vec3s(0.5f); },
      openvdb::Vec3s(0.125f));
  albedo->setTransform(transform);
  write(file("half.vdb"), {full_density(), roughness, albedo});
  const Voxels voxels = read_vdb(file("half.vdb")).voxels;
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    const float expected = i[0] < 8 ? 0 : i[0] < 12 ? 0.25f : 0.75f;
    ASSERT_EQ(voxels.roughness->at(i)[0], expected) << i[0];
    ASSERT_EQ(voxels.albedo->at(i)[1], i[0] < 8 ? 0.125f : 0.5f) << i[0];
  });
  // Turned grids have no place among upright voxels.
  const auto turned = Transform::createLinearTransform(1.0 / 8);
  turned->postRotate(0.3, openvdb::math::Z_AXIS);
  albedo->setTransform(turned);
  expect_part(refusal({full_density(), albedo}), {"grid \"albedo\"", "rotates"});
}

TEST_F(VdbFile, TakesInactiveVoxelsAndBackgroundsAsTheAccessorAnswers) {
  const auto density = openvdb::FloatGrid::create(0.5f);
  density->setName("density");
  density->tree().setValueOn({0, 0, 0}, 2.0f);
  density->tree().setValueOn({19, 9, 9}, 3.0f);
  density->tree().setValueOff({5, 5, 5}, 4.0f);
  density->tree().fill(openvdb::CoordBBox({8, 0, 0}, {15, 7, 7}), 1.5f, /*active=*/false);
  write(file("off.vdb"), {density});
  const Voxels voxels = read_vdb(file("off.vdb")).voxels;
  const auto accessor = density->getConstAccessor();
  ASSERT_EQ(voxels.extent().voxels, (VoxelIndex{20, 10, 10}));
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    ASSERT_EQ(voxels.density.at(i)[0], accessor.getValue({i[0], i[1], i[2]}));
  });
  // A background that is no density counts only where a voxel has it.
  const auto negative = openvdb::FloatGrid::create(-1.0f);
  negative->setName("density");
  negative->fill(openvdb::CoordBBox({0, 0, 0}, {9, 9, 9}), 1.0f);
  EXPECT_EQ(refusal({negative}), "no refusal");
  negative->tree().setValueOn({12, 0, 0}, 1.0f);
  expect_part(refusal({negative}), {"found -1 at voxel (10, 0, 0)", "0 or more"});
}

TEST_F(VdbFile, TellsTheTileFromMetadataSizeOrKeyAndWarnsOfContradictions) {
  const auto has = [](const VdbGrids& grids, const char* part) {
    for (const std::string& warning : grids.warnings)
      if (warning.find(part) != std::string::npos) return true;
    return false;
  };
  const VoxelIndex whole{16, 16, 8}, crop{4, 16, 4};
  write(file("stripe.vdb"), {stripe(1.0 / 16)});
  VdbGrids grids = read_vdb(file("stripe.vdb"));
  EXPECT_EQ(grids.voxels.extent().voxels, crop);
  EXPECT_EQ(grids.first_voxel, (VoxelIndex{4, 0, 2}));
  grids = read_vdb(file("stripe.vdb"), of_size(1, 1, 0.5));
  EXPECT_EQ(grids.voxels.extent().voxels, whole);
  EXPECT_TRUE(has(grids, "voxels = [16, 16, 8]"));
  // 0.25 x 1 x 0.25 in the file, a cube in the layer.
  grids = read_vdb(file("stripe.vdb"), of_size(0.9, 0.9, 0.9));
  EXPECT_EQ(grids.voxels.extent().voxels, crop);
  EXPECT_TRUE(has(grids, "measure 0.25 x 1 x 0.25, size and thickness say 0.9 x 0.9 x 0.9"));
  VdbRequest request = of_size(1, 1, 0.5);
  request.voxels = whole;
  grids = read_vdb(file("stripe.vdb"), request);
  EXPECT_EQ(grids.voxels.extent().voxels, whole);
  EXPECT_TRUE(grids.warnings.empty());
  EXPECT_EQ(grids.voxels.density.at({4, 0, 2})[0], 1);
  EXPECT_EQ(grids.voxels.density.at({3, 0, 2})[0], 0);
  request.voxels = crop;
  request.first_voxel = {4, 0, 2};
  grids = read_vdb(file("stripe.vdb"), request);
  EXPECT_EQ(grids.voxels.density.at({0, 0, 0})[0], 1);
  EXPECT_TRUE(has(grids, "measure 0.25 x 1 x 0.25"));
  request.first_voxel = {0, 0, 0};
  try {
    (void)read_vdb(file("stripe.vdb"), request);
    ADD_FAILURE() << "voxels outside of the tile";
  } catch (const GridFileError& error) {
    expect_part(error.what(), {"found voxels (4, 0, 2) to (7, 15, 5)", "(0, 0, 0) to (3, 15, 3)",
                               "key \"voxels\""});
  }
  // Voxels of edge 1 are what a grid has of which nobody said a size.
  write(file("plain.vdb"), {from_array<openvdb::FloatGrid>("density", {16, 16, 8}, 1,
                                                           [](VoxelIndex) { return 1.0f; })});
  EXPECT_TRUE(read_vdb(file("plain.vdb"), of_size(1, 1, 0.5)).warnings.empty());
  EXPECT_FALSE(read_vdb(file("plain.vdb"), of_size(1, 1, 1)).warnings.empty());
  // Blender's caches.
  const auto cache = stripe(1.0 / 16);
  cache->insertMeta("file_base_resolution", openvdb::Vec3IMetadata({16, 16, 8}));
  write(file("cache.vdb"), {cache});
  grids = read_vdb(file("cache.vdb"));
  EXPECT_EQ(grids.voxels.extent().voxels, whole);
  EXPECT_NE(grids.extent_source.find("file_base_resolution"), std::string::npos);
  // No active voxel, but a background and a tile.
  const auto constant = openvdb::FloatGrid::create(2);
  constant->setName("density");
  write(file("constant.vdb"), {constant});
  request = {};
  request.voxels = VoxelIndex{3, 4, 5};
  EXPECT_EQ(read_vdb(file("constant.vdb"), request).voxels.density.at({2, 3, 4})[0], 2);
  EXPECT_NE(refusal_of(file("constant.vdb")).find("empty grid"), std::string::npos);
  const auto negative = openvdb::FloatGrid::create(-1);
  negative->setName("density");
  write(file("negative.vdb"), {negative});
  try {
    (void)read_vdb(file("negative.vdb"), request);
    ADD_FAILURE() << "a background that is no density";
  } catch (const GridFileError& error) {
    expect_part(error.what(), {"found -1 at voxel (0, 0, 0), the background", "0 or more"});
  }
}

TEST_F(VdbFile, ReadsGridsByNameAndNothingElse) {
  const auto density = grid_with<openvdb::FloatGrid>("density", 1);
  const auto points = grid_with<openvdb::FloatGrid>("points", 1);
  write(file("known.vdb"), {density, points});
  // A type that OpenVDB does not know: its name in the file is replaced.
  std::ifstream in(file("known.vdb"), std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::string type = "Tree_float_5_4_3";
  const std::size_t last = bytes.rfind(type);
  ASSERT_NE(last, std::string::npos);
  bytes.replace(last, type.size(), "Tree_float_9_9_9");
  std::ofstream(file("unknown.vdb"), std::ios::binary) << bytes;
  EXPECT_EQ(read_vdb(file("unknown.vdb")).voxels.density.at({0, 0, 0})[0], 1);
  VdbRequest request;
  const auto refused = [&](const std::string& name) {
    try {
      (void)read_vdb(file(name), request);
    } catch (const GridFileError& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  request.names[0] = "points";
  expect_part(refused("unknown.vdb"), {"grid \"points\"", "Tree_float_9_9_9", "float"});
  EXPECT_EQ(read_vdb(file("known.vdb"), request).voxels.density.at({0, 0, 0})[0], 1);
  request.names[0] = "Density";
  expect_part(refused("known.vdb"), {"\"Density\"", "did you mean \"density\"?"});
  request.names = {"density", "orientation", "roughness", "point"};
  request.required[3] = true;
  expect_part(refused("known.vdb"), {"named \"point\"", "did you mean \"points\"?"});
  write(file("twins.vdb"), {density, grid_with<openvdb::FloatGrid>("density", 2)});
  expect_part(refusal_of(file("twins.vdb")), {"two grids named \"density\"", "allowed: one"});
  write(file("case.vdb"), {density, grid_with<openvdb::Vec3SGrid>("Albedo", {1, 1, 1})});
  const VdbGrids grids = read_vdb(file("case.vdb"));
  EXPECT_FALSE(grids.voxels.albedo);
  ASSERT_EQ(grids.warnings.size(), 1u);
  EXPECT_NE(grids.warnings[0].find("albedo_grid = \"Albedo\""), std::string::npos);
}

}  // namespace
}  // namespace lamella
