#pragma once

// Tables of ways out through interfaces, as loops on lanes read them.

#include <cstdint>

#include "volume/lanes/lane_step.h"

namespace lamella {

/// Walks of a batch that share a set of ways, as a power of two.
inline constexpr int kWaysShift = 7;

/// Segments of ways in one layer to sixteen neighbouring targets; of those without one `sent` is 0.
struct alignas(64) LaneWayBlock {
  static constexpr int kCount = 16;
  float x[kCount], y[kCount], z[kCount];  ///< direction of the light in the layer
  float rate[kCount];                     ///< optical depth per depth: sigma(-w) / |w.z|
  /// What of the light that an event sends along w arrives at the target as f: ExitPaths' `through`
  /// over |w.z|; at a Lambertian substrate over pi.
  float sent[kCount];
};

/// A set of ways: the blocks of each layer, of the substrate behind the layers.
struct LaneWays {
  const LaneWayBlock* of[kMostLaneLayers + 1] = {};
  const std::int32_t* first_target[kMostLaneLayers + 1] = {};  ///< of each block: a multiple of 16
  int count[kMostLaneLayers + 1] = {};
};

/// What lanes take as a layer is a layer, or a part of a deep one.
struct LaneWayPlaces {
  int layer[kMostLaneLayers + 1] = {};    ///< of a part: the layer's number in LaneWays
  float above[kMostLaneLayers + 1] = {};  ///< depth of the layer above the part
  float depth[kMostLaneLayers + 1] = {};  ///< of the layer
};

}  // namespace lamella
