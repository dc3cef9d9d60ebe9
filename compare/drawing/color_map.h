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
/// Of the 256 entries of RdBu the 128 below and the 128 above its middle, in equal steps of |t|;
/// t = 0 is the neutral colour between them.
[[nodiscard]] Color diverging_color(double t);

}  // namespace lamella
