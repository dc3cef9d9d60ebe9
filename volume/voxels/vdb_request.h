#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "phase/math/vec3.h"
#include "volume/voxels/voxels.h"

namespace lamella {

/// A grid file that is refused. what() names the value found and the values allowed.
struct GridFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The grids and the tile that are wanted of a .vdb file.
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

/// The grids and the tile that were found in it.
struct VdbGrids {
  Voxels voxels;
  VoxelIndex first_voxel{};             ///< index in the file of voxel (0, 0, 0)
  std::string extent_source{};          ///< origin of the tile's extent, for people
  std::vector<std::string> warnings{};  ///< one line each, file named
};

/// Measures of a bed of overlapping equal spheres as a level set.
struct LevelSetMeasure {
  double volume_fraction = 0;  ///< of the box that is inside a sphere
  double area_density = 0;     ///< surface of the union per volume of the box [1/mm]
};

}  // namespace lamella
