#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "phase/math/vec3.h"
#include "volume/voxels/voxels.h"

namespace lamella {

/// A grid file that cannot be taken: what was found in it, and what is allowed.
struct GridFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What is wanted of a .vdb file.
struct VdbRequest {
  /// Names of its grids. Orientation, roughness and albedo may be missing unless `required` has the
  /// name's position in this list.
  std::array<std::string, 4> names{"density", "orientation", "roughness", "albedo"};
  std::array<bool, 4> required{true, false, false, false};
  /// The tile in voxels of the density grid, from this index on, where the user gives it.
  std::optional<VoxelIndex> voxels{};
  VoxelIndex first_voxel{};
  /// Size of the tile [mm], where known: the file's voxel size is held against it.
  std::optional<Vec3<double>> size{};
};

/// What has been found there.
struct VdbGrids {
  Voxels voxels;
  VoxelIndex first_voxel{};             ///< index in the file of voxel (0, 0, 0)
  std::string extent_source{};          ///< where the tile's extent comes from, for people
  std::vector<std::string> warnings{};  ///< one line each, file named
};

}  // namespace lamella
