#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "phase/math/direction.h"
#include "volume/voxels/voxels.h"

namespace lamella {

/// How the space of a grid is cut into cells of one majorant each.
enum class MajorantCells {
  adaptive,  ///< blocks, merged in powers of two where that saves time
  blocks,    ///< every block for itself
  global     ///< one cell for all: the textbook's delta tracking
};

/// A cell of one majorant: the blocks of 2^level along each axis that are aligned with it.
struct MajorantCell {
  float density = 0;          ///< largest of its voxels
  std::uint8_t level = 0;     ///< the same for all blocks of the cell
  std::uint8_t roughest = 0;  ///< largest palette index of its voxels
};

/// Axes of a cell's flakes: a cone of directions (for two-sided media of lines).
struct AxisCone {
  float x = 0, y = 0, z = 1, cosine = 1, sine = 0;
};

/// The fields that majorants bound: the voxels' density, and the axis and roughness that change
/// sigma from voxel to voxel.
struct MajorantInput {
  const VoxelField<1>& density;
  const std::optional<VoxelField<3>>& axis;           ///< unit, where flakes are turned
  const std::optional<VoxelField<1>>& palette_index;  ///< where roughness varies
  Direction voxel_size;                               ///< edges of a voxel [mm]
  double layer_density;                               ///< [1/mm]
  bool two_sided;                                     ///< whether an axis and its opposite are one
};

/// The cells, one entry per block of the grid; cones only with an axis field.
struct MajorantTable {
  std::vector<MajorantCell> cells;
  std::vector<AxisCone> cones;
};

[[nodiscard]] MajorantTable majorant_table(const MajorantInput& input, MajorantCells kind);

}  // namespace lamella
