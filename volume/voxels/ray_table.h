#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "volume/voxels/density_grid.h"

namespace lamella {

/// A density grid in the numbers of lanes: float, two gathers from block to voxel. For media whose
/// sigma does not depend on the voxel, and for SGGX flakes turned by an orientation grid, with or
/// without a roughness grid.
struct GridRayTable {
  /// Voxels and grids that lanes take: a place in voxels is a float, whose last place is then at
  /// most 2^-12; an entry's index has 31 bits.
  static constexpr int kMostVoxelsAcross = 4096;
  static constexpr std::size_t kMostRecords = std::size_t{1} << 22;

  VoxelIndex voxels{}, blocks{};
  /// Per block four numbers: the largest density of its cell; then the bits of the cell's edge in
  /// voxels less 1, of the block's first record, and of 511 (0: one record for the block).
  std::vector<float> block_entries;
  /// turned: per voxel rho^2 across^2 and the axis times rho sqrt(|along^2 - across^2|), so that
  /// (rho sigma(w))^2 is the first plus `sign` times the square of (the others . w); along, across:
  /// sigma along the axis and across it. Not turned: rho alone, to be multiplied by sigma(w).
  std::vector<float> records;
  bool turned = false;
  float sign = 0;
  /// turned: a bound of sigma(w) for every w and voxel; else 0.
  double largest_sigma = 0;
};

/// nullptr where lanes have no table for the grid: vMF flakes that are turned, a roughness grid
/// alone, very many voxels.
[[nodiscard]] std::shared_ptr<const GridRayTable> make_ray_table(const DensityGrid& grid);

}  // namespace lamella
