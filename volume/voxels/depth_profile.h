#pragma once

#include <optional>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/voxels/density_grid.h"

namespace lamella {

/// The distance of a grid from a stack of homogeneous layers.
struct LateralContrast {
  /// Root of the mean square of (density - mean of its slice), over the mean density: 0 if the
  /// density varies with depth alone. Dimensionless.
  double voxel = 0;
  /// Standard deviation over the columns of the density summed over the column, over its mean: the
  /// contrast at normal incidence.
  double column = 0;
  /// Share of the voxels that hold anything.
  double filled = 0;
};

[[nodiscard]] LateralContrast lateral_contrast(const DensityGrid& grid);

/// The layers that replace one with a grid, from the top down: a slice of voxels becomes a layer
/// with the slice's mean density; equal neighbours join. Flakes that vary become the slice's
/// density-weighted mean: of S for SGGX (`matrix`), of normals and roughness for vMF, and of the
/// albedo.
[[nodiscard]] std::vector<Layer> depth_profile(const Layer& layer, const DensityGrid& grid);

/// The stack with depth profiles in the place of its grids. grids: as in Plan.
[[nodiscard]] Stack homogenised(const Stack& stack,
                                const std::vector<std::shared_ptr<const DensityGrid>>& grids);

/// The same voxels with (density - mean of the slice) multiplied by `factor` in [0, 1]: 0 is the
/// profile, 1 the grid itself. The other fields of the voxels stay.
[[nodiscard]] Voxels with_contrast(const Voxels& voxels, double factor);

}  // namespace lamella
