#pragma once

#include <cstdint>

#include "phase/lanes/isa.h"
#include "volume/grid_walk/lane_grid.h"

namespace lamella {

/// Rays that lanes follow at once; arrays of a task have room for this many.
inline constexpr int kShadowRays = 256;

/// Rays from places in a density grid to its top or bottom. Per ray: the place and the speed in
/// voxels and voxels per mm, the direction that the light comes from, what the extinction is a
/// multiple of and what bounds it [1/mm], and the names of its random numbers.
struct ShadowTask {
  LaneGrid grid;
  const float *place[3]{}, *speed[3]{}, *from[3]{};
  const float *scale = nullptr, *bound = nullptr;
  const std::uint32_t *ordinal = nullptr, *walk_low = nullptr, *walk_high = nullptr;
  std::uint32_t key_low = 0, key_high = 0;
  int count = 0;
  float* share = nullptr;  ///< out: the estimated transmittance
};

/// How a task ended.
enum class ShadowEnd : std::uint32_t { done, majorant_too_low, endless };

LAMELLA_LANE_FUNCTION(ShadowEnd, follow_shadow_rays, (const ShadowTask& task))

}  // namespace lamella
