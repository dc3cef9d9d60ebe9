#pragma once

#include <optional>
#include <span>
#include <string>

#include "phase/stack/stack.h"

namespace lamella {

/// Why a stack has no solution in spherical harmonics, if it has none.
[[nodiscard]] std::optional<std::string> why_not_harmonic(const Stack& stack);

/// The width of the narrowest phase function in the stack, or the roughness of facets that tell x
/// from y, the ground's included [radians], 1 at the most: the degree that a solution takes grows
/// with its inverse.
[[nodiscard]] double narrowest_feature(const Stack& stack);

/// Whether a stack without boundaries and some incident directions are the same at y and -y, so
/// that all light in it is: axes of flakes and directions lie in the plane y = 0.
[[nodiscard]] bool is_even(const Stack& stack, std::span<const Direction> incident);

}  // namespace lamella
