#pragma once

#include <cstdint>

namespace lamella {

/// A colour of a picture, sRGB.
struct Color {
  std::uint8_t r = 0, g = 0, b = 0;
  friend constexpr bool operator==(Color, Color) = default;
};

/// Viridis for magnitudes, t in [0, 1] (clamped; nan gives 0): lightness rises all the way.
/// Entry floor(256 t) of the published map's 256.
[[nodiscard]] Color viridis(double t);

/// Blue for negative, near white for 0, red for positive: t in [-1, 1] (clamped; nan gives 0).
/// ColorBrewer's RdBu with 11 classes, reversed, linear in between: t = 2 i / 255 - 1 gives entry i
/// of the 256 that matplotlib's RdBu_r has, and t = 0 the neutral colour between two of them.
[[nodiscard]] Color diverging_color(double t);

}  // namespace lamella
