#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compare/drawing/color_map.h"

namespace lamella {

/// A grid of pixels that is laid into a picture: transparent at first.
class Raster {
 public:
  Raster(int width, int height);
  /// Covers a share of the pixel, coverage in [0, 1].
  void set(int x, int y, Color color, double coverage = 1);
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// 0xAARRGGBB, colours multiplied by the coverage, row by row from the top.
  [[nodiscard]] std::span<const std::uint32_t> pixels() const { return pixels_; }

 private:
  int width_, height_;
  std::vector<std::uint32_t> pixels_;
};

}  // namespace lamella
