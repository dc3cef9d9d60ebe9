#pragma once

#include <array>
#include <optional>
#include <span>
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

/// Whether this build reads and writes .vdb files (CMake option LAMELLA_OPENVDB).
[[nodiscard]] bool has_openvdb();
/// Version of OpenVDB that the program was built with; empty without it.
[[nodiscard]] std::string openvdb_version();

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

/// Reads a .vdb file, as README.md says under "Grid files": the density (float, >= 0) and, where
/// they are, orientation and albedo (three floats; albedo in [0, 1]) and roughness (float, in
/// (0, 1]), all on the voxels of the density. The value of a voxel, active or not, is what
/// OpenVDB's accessor answers. OpenVDB works in a child process with bounded memory and time, so
/// that a damaged file ends in an error. Throws GridFileError with what was found and what is
/// allowed, file, grid and voxel named.
[[nodiscard]] VdbGrids read_vdb(const std::string& path, const VdbRequest& request = {});

/// Writes the voxels, edges of `voxel_size` [mm], as a .vdb file that read_vdb reads back the same.
/// Throws GridFileError.
void write_vdb(const std::string& path, const Voxels& voxels, Vec3<double> voxel_size);

/// What a bed of overlapping equal spheres measures as a level set.
struct LevelSetMeasure {
  double volume_fraction = 0;  ///< of the box that is inside a sphere
  double area_density = 0;     ///< surface of the union per volume of the box [1/mm]
};

/// Rasterises spheres of one radius [mm] with OpenVDB's ParticlesToLevelSet on cubic voxels of edge
/// `voxel` [mm] and measures them in the box [0, size): volume by the share of each voxel that the
/// signed distance leaves inside, area by the gradient of that share. Both blur the surface by a
/// standard deviation of 0.54 voxels, an error of the second order in it for smooth surfaces.
/// `centres` [mm]: of all spheres that reach the box, images of periodic neighbours among them.
/// Throws GridFileError in a build without OpenVDB.
[[nodiscard]] LevelSetMeasure measure_level_set(std::span<const Vec3<double>> centres,
                                                double radius, double voxel, Vec3<double> size);

}  // namespace lamella
