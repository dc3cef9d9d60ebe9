#include "volume/grid_walk/lane_grid.h"

#include "volume/voxels/ray_table.h"

namespace lamella {

LaneGrid lane_grid_of(const GridRayTable& table) {
  LaneGrid grid;
  grid.block_entries = table.block_entries.data();
  grid.records = table.records.data();
  grid.turned = table.turned;
  grid.sign = table.sign;
  for (int a = 0; a < 3; ++a) {
    grid.voxels[a] = static_cast<std::uint32_t>(table.voxels[a]);
    grid.blocks[a] = static_cast<std::uint32_t>(table.blocks[a]);
  }
  return grid;
}

}  // namespace lamella
