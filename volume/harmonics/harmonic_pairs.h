#pragma once

#include <span>
#include <utility>
#include <vector>

#include "volume/harmonics/harmonic_run.h"

namespace lamella {

/// f [1/sr] of all orders at a pair of directions, and its bound.
struct HarmonicPair {
  Rgb f, error;
};

/// f at pairs (w_i, w_o): order 1 in closed form, what mirrors scatter twice by quadrature
/// (mirror_pairs.h), the rest in spherical harmonics, whose degree rises until every bound is
/// within the tolerance of its value. A bound is the change under the last step, or, once the
/// changes fall, three times what the next one would be, of the pair or the mean over all pairs
/// (root of squares, relative to f), whichever is larger. accuracy: what was reached at worst.
/// Refused as by harmonic_runs; a pair's cosines are not both 0.
[[nodiscard]] std::vector<HarmonicPair> harmonic_pairs(
    const Stack& stack, std::span<const std::pair<Direction, Direction>> pairs,
    const HarmonicOptions& options, DeterministicAccuracy& accuracy);

}  // namespace lamella
