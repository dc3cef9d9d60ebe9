#pragma once

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <string>

#include "volume/voxels/vdb_file.h"

namespace lamella::testing {

// A folder of the test's own.
class VdbFile : public ::testing::Test {
 protected:
  void SetUp() override {
    openvdb::initialize();
    std::string pattern = (std::filesystem::temp_directory_path() / "lamella-vdb-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_ / name).string();
  }
  // What read_vdb says of a file with these grids.
  [[nodiscard]] std::string refusal(const openvdb::GridCPtrVec& grids) const {
    const std::string path = file("broken.vdb");
    openvdb::io::File(path).write(grids);
    return refusal_of(path);
  }
  [[nodiscard]] static std::string refusal_of(const std::string& path) {
    try {
      (void)read_vdb(path);
    } catch (const GridFileError& error) {
      return error.what();
    }
    return "no refusal";
  }

 private:
  std::filesystem::path folder_;
};

template <class Grid>
typename Grid::Ptr grid_with(const std::string& name, typename Grid::ValueType value,
                             openvdb::Coord where = {1, 2, 3}) {
  const auto grid = Grid::create();
  grid->setName(name);
  grid->tree().setValue(where, value);
  return grid;
}

inline void expect_part(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << text;
  EXPECT_NE(text.find("allowed: "), std::string::npos) << text;
}

// As pyopenvdb's copyFromArray: values that are the background stay inactive.
template <class Grid, class F>
typename Grid::Ptr from_array(const std::string& name, VoxelIndex n, double voxel, const F& f,
                              typename Grid::ValueType background = typename Grid::ValueType(0)) {
  const auto grid = Grid::create(background);
  grid->setName(name);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
  auto accessor = grid->getAccessor();
  for_each_voxel(VoxelExtent{n}, [&](VoxelIndex i) {
    const auto value = f(i);
    if (value != background) accessor.setValue({i[0], i[1], i[2]}, value);
  });
  return grid;
}

inline openvdb::FloatGrid::Ptr full_density() {
  return from_array<openvdb::FloatGrid>("density", {16, 16, 8}, 1.0 / 16,
                                        [](VoxelIndex) { return 1.0f; });
}

// A quarter of the tile, between margins of zeros.
inline openvdb::FloatGrid::Ptr stripe(double voxel) {
  return from_array<openvdb::FloatGrid>("density", {16, 16, 8}, voxel, [](VoxelIndex i) {
    return i[0] >= 4 && i[0] < 8 && i[2] >= 2 && i[2] < 6 ? 1.0f : 0.0f;
  });
}

inline void write(const std::string& path, const openvdb::GridCPtrVec& grids) {
  openvdb::io::File(path).write(grids);
}

}  // namespace lamella::testing
