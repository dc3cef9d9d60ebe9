#pragma once

#include <span>
#include <string>
#include <vector>

#include "compare/drawing/color_map.h"

namespace lamella {

/// A map from values to colours, with its ticks. low and high are round numbers.
struct ColorScale {
  enum class Kind { linear, logarithmic, diverging };

  struct Tick {
    double position;  ///< in [0, 1], 0 at low
    std::string label;
  };

  Kind kind = Kind::linear;
  double low = 0, high = 1;  ///< logarithmic: both positive; diverging: low = -high
  double step = 1;           ///< between ticks, unless logarithmic

  /// Place of a value between low (0) and high (1), clamped.
  [[nodiscard]] double position(double value) const;
  [[nodiscard]] Color color_at(double position) const;
  /// Colour of a value that is not nan.
  [[nodiscard]] Color color(double value) const { return color_at(position(value)); }
  [[nodiscard]] std::vector<Tick> ticks() const;
};

/// One scale for two maps of magnitudes (either may be empty): from 0, or from the lowest value if
/// that is negative, to at least the highest. Logarithmic: over their positive values, at most
/// about six decades; linear if there is no positive value. Values that are not finite don't count.
[[nodiscard]] ColorScale magnitude_scale(std::span<const double> a, std::span<const double> b,
                                         bool logarithmic);

/// Symmetric about 0, to at least the largest finite magnitude.
[[nodiscard]] ColorScale signed_scale(std::span<const double> values);

/// Logarithmic, for errors over their bounds: whole decades, from 0.1 to at least the largest
/// finite magnitude and to 10, so that 1 is inside.
[[nodiscard]] ColorScale ratio_scale(std::span<const double> values);

/// Symmetric about 0, to a limit that is fixed beforehand, with ticks every `step`.
[[nodiscard]] ColorScale fixed_signed_scale(double limit, double step);

}  // namespace lamella
