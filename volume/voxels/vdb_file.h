#pragma once

#include <span>
#include <string>

#include "phase/math/vec3.h"
#include "volume/voxels/vdb_request.h"
#include "volume/voxels/voxels.h"

namespace lamella {

// All of OpenVDB lies in a module, a shared object that the first call below loads (vdb_module.h):
// a program that reads no .vdb file does not pay for it. Where it cannot be loaded GridFileError
// says so.

/// Whether this build reads and writes .vdb files (CMake option LAMELLA_OPENVDB).
[[nodiscard]] bool has_openvdb();
/// Version of OpenVDB that the module was built with; empty in a build without it. Throws
/// GridFileError.
[[nodiscard]] std::string openvdb_version();

/// Reads a .vdb file, as volume/README.md says under "Grid files": the density (float, >= 0) and,
/// where they are, orientation and albedo (three floats; albedo in [0, 1]) and roughness (float, in
/// (0, 1]), all on the voxels of the density. The value of a voxel, active or not, is what
/// OpenVDB's accessor answers. OpenVDB works in a child process with bounded memory and time, so
/// that a damaged file ends in an error. Throws GridFileError, which names file, grid, voxel, the
/// value found and the values allowed.
[[nodiscard]] VdbGrids read_vdb(const std::string& path, const VdbRequest& request = {});

/// Writes the voxels, edges of `voxel_size` [mm], as a .vdb file that read_vdb reads back the same.
/// Throws GridFileError.
void write_vdb(const std::string& path, const Voxels& voxels, Vec3<double> voxel_size);

/// Rasterises spheres of one radius [mm] with OpenVDB's ParticlesToLevelSet on cubic voxels of edge
/// `voxel` [mm] and measures them in the box [0, size): volume by the share of each voxel that the
/// signed distance leaves inside, area by the gradient of that share. Both blur the surface by a
/// standard deviation of 0.54 voxels, an error of the second order in it for smooth surfaces.
/// `centres` [mm]: of all spheres that reach the box, images of periodic neighbours among them.
/// Throws GridFileError in a build without OpenVDB.
[[nodiscard]] LevelSetMeasure measure_level_set(std::span<const Vec3<double>> centres,
                                                double radius, double voxel, Vec3<double> size);

}  // namespace lamella
