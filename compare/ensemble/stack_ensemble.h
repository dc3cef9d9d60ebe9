#pragma once

#include <cstdint>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// Stack `number` of an ensemble of random SpongeCake stacks: `layers` layers (1 or more) of SGGX
/// mirror flakes over the ranges of SpongecakeRanges, without a substrate, each number drawn for
/// itself. Per layer, with probability 1/2 each: surface or fiber; f0 of 1 (no Fresnel factor), or
/// three values; and an axis at home (surfaces: the normal; fibers: horizontal, any azimuth), or
/// one that is uniform over the sphere. Roughness, albedo and f0 are uniform over their range,
/// depth (thickness at density 1) is uniform in its logarithm. Depends on (seed, layers, number)
/// alone.
[[nodiscard]] Stack random_spongecake_stack(int layers, std::uint64_t seed, std::uint64_t number);

/// `count` incident directions of that stack, above it: mu stratified over [0.02, 1], azimuth
/// uniform.
[[nodiscard]] std::vector<Direction> random_directions(int count, int layers, std::uint64_t seed,
                                                       std::uint64_t number);

/// A layer of SGGX mirror flakes as a stack file describes it.
[[nodiscard]] Layer flake_layer(bool fiber, double roughness, Direction axis, Rgb albedo, Rgb f0,
                                double thickness);

}  // namespace lamella
