#pragma once

#include <cstdint>

namespace lamella {

struct GridRayTable;

/// A density grid as lanes see it: the tables of a GridRayTable, which must outlive it.
struct LaneGrid {
  const float *block_entries = nullptr, *records = nullptr;
  bool turned = false;
  float sign = 0;
  std::uint32_t voxels[3]{}, blocks[3]{};
};

[[nodiscard]] LaneGrid lane_grid_of(const GridRayTable& table);

/// Widens majorants by more than the rounding of float.
inline constexpr double kMajorantMargin = 1 + 4e-6;
/// The last place in float below the end of an extent of n voxels, over n.
inline constexpr double kBelowEnd = 1 - 0x1p-23;

}  // namespace lamella
