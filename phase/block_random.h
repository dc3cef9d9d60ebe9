#pragma once

#include "phase/real.h"

namespace lamella {

/// The random words of one event, per lane (phase/lane_random.h) or for one walk.
template <class Words>
struct WordBlock {
  Words w[4];
};

// The same numbers as phase/lane_random.h draws from words, in double and hence without rounding.

/// Uniform in (0, 1), an odd multiple of 2^-24, from the upper 23 bits of a word.
LAMELLA_INLINE double uniform_of(std::uint32_t bits) { return ((bits >> 9) + 0.5) * 0x1p-23; }

/// Uniform like uniform_of from the nine bits of each of three words that it leaves.
LAMELLA_INLINE double uniform_of_rest(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return (((a & 511u) | (b & 511u) << 9 | (c & 31u) << 18) + 0.5) * 0x1p-23;
}

/// Uniform in (0, 1], to all 32 bits of a word.
LAMELLA_INLINE double fine_uniform_of(std::uint32_t bits) { return (bits + 0.5) * 0x1p-32; }

}  // namespace lamella
