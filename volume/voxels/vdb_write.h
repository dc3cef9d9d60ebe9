#pragma once

#include <span>
#include <string>

#include "phase/math/vec3.h"
#include "volume/voxels/vdb_request.h"
#include "volume/voxels/voxels.h"

namespace lamella {

/// write_vdb and measure_level_set of vdb_file.h, inside of the module. Throw GridFileError.
void write_vdb_grids(const std::string& path, const Voxels& voxels, Vec3<double> voxel_size);
[[nodiscard]] LevelSetMeasure measure_spheres(std::span<const Vec3<double>> centres, double radius,
                                              double voxel, Vec3<double> size);

}  // namespace lamella
