#pragma once

#include <cstdint>

namespace lamella {

/// A colour of a picture, sRGB.
struct Color {
  std::uint8_t r = 0, g = 0, b = 0;
  friend constexpr bool operator==(Color, Color) = default;
};

/// Viridis for magnitudes, t in [0, 1] (clamped; nan gives 0): lightness rises all the way.
/// Ten of the control points of Smith and van der Walt's map of 2015, linear in between.
[[nodiscard]] Color viridis(double t);

/// Blue for negative, near white for 0, red for positive: t in [-1, 1] (clamped; nan gives 0).
/// ColorBrewer's RdBu with 11 classes, reversed, linear in between.
[[nodiscard]] Color diverging_color(double t);

}  // namespace lamella
