#pragma once

#include "phase/math/real.h"
#include "phase/math/trigonometry.h"

namespace lamella {

/// Four random words, per lane (phase/random/lane_random.h) or for one walk.
template <class Words>
struct WordBlock {
  Words w[4];
};

template <int n>
LAMELLA_INLINE std::uint32_t rotate_left(std::uint32_t a) {
  return a << n | a >> (32 - n);
}

/// The numbers of one walk: xoshiro128+ (Blackman and Vigna 2021, "Scrambled linear pseudorandom
/// number generators"), with a block of the counter-based generator as state: the numbers of a walk
/// depend on (seed, walk) alone, and a word takes fewer instructions than one of the counter-based
/// generator. The lowest bits of xoshiro's words are linear in the state; the numbers below round
/// them away.
template <class Words>
struct WalkNumbers {
  Words s[4];

  WalkNumbers() = default;
  LAMELLA_INLINE explicit WalkNumbers(const WordBlock<Words>& from)
      : s{from.w[0], from.w[1], from.w[2], from.w[3]} {}

  LAMELLA_INLINE Words next() {
    const Words result = s[0] + s[3];
    const Words s31 = s[3] ^ s[1], shifted = shift_left<9>(s[1]);
    const Words s1 = xor_of(s[1], s[2], s[0]);
    s[2] = xor_of(shifted, s[2], s[0]);
    s[0] = xor_of(s[0], s[3], s[1]);
    s[1] = s1;
    s[3] = rotate_left<11>(s31);
    return result;
  }
};

// The same numbers as phase/random/lane_random.h draws from words, in double and hence without
// rounding.

/// Uniform in (0, 1), an odd multiple of 2^-24, from the upper 23 bits of a word.
LAMELLA_INLINE double uniform_of(std::uint32_t bits) { return ((bits >> 9) + 0.5) * 0x1p-23; }

/// Uniform in [-1, 1), from all bits of a word.
LAMELLA_INLINE double signed_uniform_of(std::uint32_t bits) {
  return static_cast<std::int32_t>(bits) * 0x1p-31;
}

/// Sine and cosine of pi signed_uniform_of(bits).
LAMELLA_INLINE SineCosine<double> azimuth_of(std::uint32_t bits) {
  return sine_cosine_of_half_turns(signed_uniform_of(bits));
}

/// Uniform in (0, 1], from the upper 31 bits of a word.
LAMELLA_INLINE double fine_uniform_of(std::uint32_t bits) { return ((bits >> 1) + 0.5) * 0x1p-31; }

/// An exponential number of mean 1, -log of fine_uniform_of: at most 22.2.
LAMELLA_INLINE double exponential_of(std::uint32_t bits) {
  return -std::log(fine_uniform_of(bits));
}

}  // namespace lamella
