#include "compare/drawing/raster.h"

#include <algorithm>

namespace lamella {

Raster::Raster(int width, int height)
    : width_(width),
      height_(height),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void Raster::set(int x, int y, Color color, double coverage) {
  const auto part = [&](int channel) {
    return static_cast<std::uint32_t>(channel * std::clamp(coverage, 0.0, 1.0) + 0.5);
  };
  pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
          static_cast<std::size_t>(x)] =
      part(255) << 24 | part(color.r) << 16 | part(color.g) << 8 | part(color.b);
}

}  // namespace lamella
