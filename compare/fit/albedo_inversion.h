#pragma once

#include <functional>
#include <stdexcept>

#include "phase/math/color.h"

namespace lamella {

/// A colour that no albedo in [0, 1] gives. what() names the colour and the range that can be
/// reached.
struct UnreachableColor : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct AlbedoInversion {
  Rgb albedo{};   ///< the single-scattering albedo
  Rgb reached{};  ///< the colour it gives
  Rgb slope{};  ///< d colour / d albedo there: an error of the colour over it is one of the albedo
  int evaluations = 0;
};

/// The albedo for which color(albedo) is `target`, per channel: color must grow with the albedo and
/// keep the channels apart. All channels at once by regula falsi (Illinois), to `tolerance` of the
/// colour. Throws UnreachableColor.
[[nodiscard]] AlbedoInversion invert_albedo(const std::function<Rgb(Rgb)>& color, Rgb target,
                                            double tolerance);

}  // namespace lamella
