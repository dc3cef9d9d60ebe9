#pragma once

#include <array>
#include <span>

#include "phase/math/color.h"

namespace lamella {

/// Weights of linear red, green and blue in the luminance Y: ITU-R BT.709-6, item 3.2. They sum to
/// 1, so that grey keeps its value.
inline constexpr std::array<double, 3> kLuminanceWeights{0.2126, 0.7152, 0.0722};
/// The name of the one number that stands for all three channels of a colour.
inline constexpr const char* kLuminanceName = "luminance (Rec. 709)";

/// The one number that stands for a colour: in tables, pages and pictures. Linear, in the unit of
/// the channels.
[[nodiscard]] constexpr double luminance(Rgb c) {
  return kLuminanceWeights[0] * c.r + kLuminanceWeights[1] * c.g + kLuminanceWeights[2] * c.b;
}

/// The luminance of a list of three channels, or the value itself of one channel. Standard errors,
/// which channels that share walks have in common, and error bounds are combined in the same way.
[[nodiscard]] constexpr double luminance(std::span<const double> channels) {
  return channels.size() == 1 ? channels[0] : luminance(Rgb(channels[0], channels[1], channels[2]));
}

}  // namespace lamella
