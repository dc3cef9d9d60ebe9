#pragma once

#include "phase/math/vec3.h"

namespace lamella {

/// How a ray through explicit geometry ends.
enum class RayEnd {
  grain,  ///< meets a grain, or a height field's surface
  up,     ///< leaves upwards: nothing is above
  down,   ///< reaches the plane z = GrainGeometry::bottom()
  lost    ///< crossed kMostTiles periods and met nothing
};

struct GrainHit {
  RayEnd end = RayEnd::up;
  Direction point{0, 0, 0};   ///< where, x and y in the tile; not set if `up` or `lost`
  Direction normal{0, 0, 1};  ///< of the surface, outwards
};

/// Periods that a ray is followed through. A ray so near to the horizontal that it would cross more
/// is counted as lost.
inline constexpr int kMostTiles = 100000;

}  // namespace lamella
