#pragma once

#include <cstdint>
#include <vector>

#include "phase/grains/grain_geometry.h"
#include "volume/grains/ray_end.h"

namespace lamella {

/// One realisation of a Gaussian random surface in its periodic tile
/// (GrainPlacement::height_field), ready to be traced: white noise on the nodes, smoothed by a
/// Gaussian, and two triangles per square of nodes.
///
/// A ray is followed from square to square in double precision. Within a triangle its height above
/// the surface is linear in the distance, so that a hit is where that becomes negative: nothing
/// passes between two triangles, and a ray that leaves a triangle never meets it again, whatever
/// the rounding. Embree has nothing to add here: a ray needs the few squares that it crosses, and
/// floats would have to be mended at every hit.
class HeightField {
 public:
  /// `geometry` in any unit. The same for equal arguments.
  HeightField(const GrainGeometry& geometry, std::uint64_t seed, std::uint64_t realisation);

  /// Follows the ray from `origin`, above the surface or on it, along the unit vector d. Any
  /// thread.
  [[nodiscard]] GrainHit trace(Direction origin, Direction d) const;
  /// Whether the ray leaves upwards.
  [[nodiscard]] bool is_free(Direction origin, Direction d) const {
    return trace(origin, d).end == RayEnd::up;
  }

  [[nodiscard]] int nodes() const { return nodes_; }
  /// Side of a square [the geometry's unit].
  [[nodiscard]] double step() const { return step_; }
  /// At a node; i and j beyond the tile are those of the period.
  [[nodiscard]] double height(std::int64_t i, std::int64_t j) const {
    return heights_[static_cast<std::size_t>(wrapped(j)) * nodes_ + wrapped(i)];
  }

 private:
  [[nodiscard]] int wrapped(std::int64_t i) const {
    const std::int64_t r = i % nodes_;
    return static_cast<int>(r < 0 ? r + nodes_ : r);
  }

  int nodes_;
  double tile_, step_, highest_ = 0, lowest_ = 0;
  std::vector<double> heights_;
};

}  // namespace lamella
