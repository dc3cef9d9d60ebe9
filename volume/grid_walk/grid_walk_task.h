#pragma once

#include <cstdint>

#include "phase/lanes/isa.h"
#include "volume/grid_walk/lane_grid.h"
#include "volume/lanes/lane_state.h"
#include "volume/lanes/lane_task.h"

namespace lamella {

/// Walks of a task at most, and what its rows have room for.
inline constexpr int kGridWalks = 2048, kGridWalkRows = kGridWalks + 64;

/// What became of the walks of a task, one row per quantity: the j-th number is that of the j-th
/// walk.
struct GridWalkEnds {
  std::uint32_t* end = nullptr;    ///< WalkEnd
  std::uint32_t* order = nullptr;  ///< events that counted
  std::uint32_t* cell = nullptr;   ///< with cells: see cell_of, for both sides alike
  float* wi[3]{};                  ///< of the last flight: light leaves along -w_i
  float* weight[3]{};              ///< per channel
};

/// Walks through a layer with a density grid. The j-th has the index (index_high, index_low + j
/// index_stride), whose lower half does not overflow.
struct GridWalkTask {
  WalkSetting<float> walk;  ///< its first layer is the grid's
  LaneGrid grid;
  float per_mm[3]{};    ///< voxels
  float density = 0;    ///< of the layer [1/mm]
  float bound = 0;      ///< turned flakes: the majorant over a cell's density; else that over sigma
  bool scaled = false;  ///< sigma(w) belongs to the direction alone, and is not 1
  bool mirror = false;  ///< turned flakes: they are mirrors
  std::uint32_t index_low = 0, index_high = 0, index_stride = 1;
  std::uint32_t point = 0, shift = 0;  ///< with a lattice: the point of the first walk; the shift
  int count = 0;
  const float* light[3]{};  ///< w_i by walk; none: that of `walk`
  LaneCells cells;
  GridWalkEnds ends;
};

/// What else a task tells.
struct GridWalkCount {
  std::uint64_t collisions = 0;
  bool majorant_too_low = false;
};

LAMELLA_LANE_FUNCTION(GridWalkCount, walk_grid_lanes, (const GridWalkTask& task))

}  // namespace lamella
