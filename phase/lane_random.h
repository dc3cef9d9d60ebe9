#pragma once

// Random numbers on lanes: a stream per lane, like RandomStream's. Only for sources of
// lamella_lanes(), see phase/lanes.h.

#include "phase/block_random.h"
#include "phase/lanes.h"

namespace lamella::LAMELLA_ISA {

using WordBlock = lamella::WordBlock<Words>;

/// Philox 4x32 with 7 rounds of the counter (c0, c1, c2, c3): the numbers of RandomStream.
/// The lanes of even and of odd place are carried apart in the halves of 64-bit products, so that
/// nothing has to be put back in order before the end.
LAMELLA_INLINE WordBlock philox(Words c0, Words c1, Words c2, Words c3, std::uint32_t key0,
                                std::uint32_t key1) {
  using Wide = hn::ScalableTag<std::uint64_t>;
  const Words m0(0xD2511F53u), m1(0xCD9E8D57u);
  struct Half {
    Words v0, v1, v2, v3;  // only the even places count
  };
  const auto odd = [](Words a) -> Words {
    return hn::BitCast(Words::Tag(), hn::ShiftRight<32>(hn::BitCast(Wide(), a.v)));
  };
  const auto product = [](Words a, Words b) -> Words {
    return hn::BitCast(Words::Tag(), hn::MulEven(a.v, b.v));
  };
  Half even{c0, c1, c2, c3}, uneven{odd(c0), odd(c1), odd(c2), odd(c3)};
  const auto round = [&](Half& h, Words k0, Words k1) {
    const Words p0 = product(m0, h.v0), p1 = product(m1, h.v2);
    h = {odd(p1) ^ h.v1 ^ k0, p1, odd(p0) ^ h.v3 ^ k1, p0};
  };
  for (int r = 0; r < 7; ++r) {
    const Words k0(key0), k1(key1);
    round(even, k0, k1);
    round(uneven, k0, k1);
    key0 += 0x9E3779B9u;
    key1 += 0xBB67AE85u;
  }
  const auto together = [](Words a, Words b) -> Words {
    const auto up = hn::BitCast(Words::Tag(), hn::ShiftLeft<32>(hn::BitCast(Wide(), b.v)));
    return hn::OddEven(up, a.v);
  };
  return {{together(even.v0, uneven.v0), together(even.v1, uneven.v1), together(even.v2, uneven.v2),
           together(even.v3, uneven.v3)}};
}

/// Uniform in (0, 1), an odd multiple of 2^-24, from the upper 23 bits of a word.
LAMELLA_INLINE Floats uniform_of(Words bits) {
  return multiply_add(to_floats(shift_right<9>(bits)), Floats(0x1p-23f), Floats(0x1p-24f));
}

/// Uniform like uniform_of from the nine bits of each of three words that it leaves.
LAMELLA_INLINE Floats uniform_of_rest(Words a, Words b, Words c) {
  const Words nine(511u);
  const Words bits = (a & nine) | shift_left<9>(b & nine) | shift_left<18>(c & Words(31u));
  return multiply_add(to_floats(bits), Floats(0x1p-23f), Floats(0x1p-24f));
}

/// Uniform in (0, 1], to all 32 bits of a word: (bits + 1/2) 2^-32, rounded to float.
LAMELLA_INLINE Floats fine_uniform_of(Words bits) {
  const Floats high = to_floats(shift_right<16>(bits));
  const Floats low = to_floats(bits & Words(0xFFFFu)) + Floats(0.5f);
  return multiply_add(high, Floats(0x1p-16f), low * Floats(0x1p-32f));
}

}  // namespace lamella::LAMELLA_ISA
