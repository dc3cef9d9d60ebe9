#pragma once

#include <cstdint>
#include <memory>

#include "volume/grains/grain_scene.h"
#include "volume/grains/height_field.h"

namespace lamella {

/// One realisation of explicit geometry of any kind, ready to be traced.
class TracedGeometry {
 public:
  TracedGeometry(const GrainGeometry& geometry, std::uint64_t seed, std::uint64_t realisation) {
    if (geometry.is_height_field())
      heights_ = std::make_unique<HeightField>(geometry, seed, realisation);
    else
      grains_ = std::make_unique<GrainScene>(geometry, place_grains(geometry, seed, realisation));
  }

  [[nodiscard]] GrainHit trace(Direction origin, Direction d) const {
    return heights_ ? heights_->trace(origin, d) : grains_->trace(origin, d);
  }
  [[nodiscard]] bool is_free(Direction origin, Direction d) const {
    return heights_ ? heights_->is_free(origin, d) : grains_->is_free(origin, d);
  }
  /// Rays that began inside of a grain by more than rounding.
  [[nodiscard]] std::uint64_t holes() const { return grains_ ? grains_->holes() : 0; }

 private:
  std::unique_ptr<GrainScene> grains_;
  std::unique_ptr<HeightField> heights_;
};

}  // namespace lamella
