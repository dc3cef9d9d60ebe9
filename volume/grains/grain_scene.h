#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>

#include "phase/grains/grain_geometry.h"
#include "volume/grains/ray_end.h"

namespace lamella {

/// Explicit geometry that cannot be traced here: the program was built without Embree.
struct GeometryError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One realisation of grains in its periodic tile, ready to be traced. The only user of Embree.
///
/// Embree finds the grains whose boxes a ray of floats meets; double precision decides which of
/// these grains the ray meets, and where. The boxes are widened by the largest shift of a ray that
/// is rounded to floats, so no grain is missed. A grain is met only where the ray enters it,
/// against the normal: so a ray that leaves a grain on the side of its normal never meets that
/// grain again, whatever the rounding of its origin, and no distance has to be skipped.
class GrainScene {
 public:
  /// `centres` as place_grains gives them. Throws GeometryError without Embree.
  GrainScene(const GrainGeometry& geometry, std::span<const Direction> centres);
  ~GrainScene();
  GrainScene(const GrainScene&) = delete;
  GrainScene& operator=(const GrainScene&) = delete;

  /// Follows the ray from `origin` along the unit vector d. Any thread.
  [[nodiscard]] GrainHit trace(Direction origin, Direction d) const;
  /// Whether the ray meets no grain: it leaves, or reaches the plane below.
  [[nodiscard]] bool is_free(Direction origin, Direction d) const;
  /// Whether any grain holds the point in its inside.
  [[nodiscard]] bool is_inside(Direction point) const;

  /// Rays that began inside of a grain by more than rounding: 0 unless something is wrong.
  [[nodiscard]] std::uint64_t holes() const;
  /// Bytes that all scenes of the program hold in Embree at this moment.
  [[nodiscard]] static std::int64_t embree_bytes();

  /// Whether this program was built with Embree.
  [[nodiscard]] static bool is_available();
  /// Throws GeometryError, which says what to do, if the program was built without Embree.
  static void require_available();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lamella
