#pragma once

// Random numbers on lanes: a stream per lane, like RandomStream's. Only for sources of
// lamella_lanes(), see phase/lanes/lanes.h.

#include "phase/lanes/lane_math.h"
#include "phase/lanes/lanes.h"
#include "phase/random/block_random.h"
#include "phase/random/lattice.h"

namespace lamella::LAMELLA_ISA {

using WordBlock = lamella::WordBlock<Words>;

/// Philox 4x32 with 7 rounds of the counter (c0, c1, c2, c3): the numbers of RandomStream.
/// The lanes of even and of odd place are carried apart in the halves of 64-bit products, so that
/// nothing has to be put back in order before the end; shuffles, not shifts, move them, as those
/// share a port with the products.
LAMELLA_INLINE WordBlock philox(Words c0, Words c1, Words c2, Words c3, std::uint32_t key0,
                                std::uint32_t key1) {
  const Words m0(0xD2511F53u), m1(0xCD9E8D57u);
  struct Half {
    Words v0, v1, v2, v3;  // only the even places count
  };
  const auto odd = [](Words a) -> Words { return hn::Shuffle2301(a.v); };
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
  const auto together = [&](Words a, Words b) -> Words { return hn::OddEven(odd(b).v, a.v); };
  return {{together(even.v0, uneven.v0), together(even.v1, uneven.v1), together(even.v2, uneven.v2),
           together(even.v3, uneven.v3)}};
}

/// table[step] per lane, of 16 words, the last eight of which repeat the first; of the step its
/// last three bits count.
LAMELLA_INLINE Words step_entry(const std::uint32_t* table, Words step) {
  constexpr int n = Words::kCount;
  if constexpr (n >= 8) {
    return permute(Words::load(table), step & Words(n == 8 ? 7u : 15u));
  } else {
    alignas(16) std::uint32_t at[n];
    alignas(16) std::uint32_t found[n];
    (step & Words(7u)).store(at);
    for (int k = 0; k < n; ++k) found[k] = table[at[k]];
    return Words::load(found);
  }
}

/// Uniform in (0, 1), an odd multiple of 2^-24, from the upper 23 bits of a word.
LAMELLA_INLINE Floats uniform_of(Words bits) {
  return multiply_add(to_floats(shift_right<9>(bits)), Floats(0x1p-23f), Floats(0x1p-24f));
}

/// Uniform in [-1, 1], from all bits of a word.
LAMELLA_INLINE Floats signed_uniform_of(Words bits) { return to_floats(bits) * Floats(0x1p-31f); }

/// Sine and cosine of pi signed_uniform_of(bits): absolute error below 6e-7, largest at the half
/// turn.
LAMELLA_INLINE SineCosine<Floats> azimuth_of(Words bits) {
  return sine_cosine_of_twice(to_floats(bits) * Floats(1.57079632679489662f * 0x1p-31f));
}

/// Uniform in (0, 1], from the upper 31 bits of a word: an odd multiple of 2^-32, rounded to float.
LAMELLA_INLINE Floats fine_uniform_of(Words bits) {
  return multiply_add(to_floats(shift_right<1>(bits)), Floats(0x1p-31f), Floats(0x1p-32f));
}

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX2
namespace detail {
/// For each of kIntervals equal intervals of [1, 2): about its middle c, 1 / c and -log(c), the
/// latter for the rounded 1 / c. In the first c = 1 and in the last c = 2, so that numbers at the
/// ends of (1/2, 1] have logarithms without cancellation.
template <int kIntervals>
struct LogTable;
template <>
struct LogTable<16> {
  static constexpr float kInverse[16] = {1.0f,         0.914285719f, 0.864864886f, 0.820512831f,
                                         0.780487776f, 0.744186044f, 0.711111128f, 0.680851042f,
                                         0.653061211f, 0.627451003f, 0.603773594f, 0.581818163f,
                                         0.561403513f, 0.542372882f, 0.524590135f, 0.5f};
  static constexpr float kLog[16] = {0.0f,          -0.0896121531f, -0.145181986f, -0.19782573f,
                                     -0.247836201f, -0.295464217f,  -0.340926563f, -0.384411731f,
                                     -0.426084416f, -0.466089695f,  -0.504555996f, -0.541597314f,
                                     -0.577315358f, -0.611801539f,  -0.645138017f, -0.693147181f};
};
template <>
struct LogTable<8> {
  static constexpr float kInverse[8] = {1.0f,         0.842105269f, 0.761904776f, 0.695652187f,
                                        0.639999986f, 0.592592597f, 0.551724136f, 0.5f};
  static constexpr float kLog[8] = {0.0f,          -0.171850249f, -0.271933697f, -0.362905475f,
                                    -0.446287125f, -0.523248136f, -0.594707111f, -0.693147181f};
};
}  // namespace detail
#endif

/// An exponential number of mean 1: -log(fine_uniform_of(bits)), absolute error below 1.2e-7 where
/// it is below 1, relative error below that elsewhere; never negative, at most 22.2.
LAMELLA_INLINE Floats exponential_of(Words bits) {
  const Floats u = fine_uniform_of(bits);
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX2
  // u = 2^e m, m in [1, 2), and log(m) = log(c) + log(1 + r), c from a table by one permutation, of
  // whose index the last bits count.
  using Table = detail::LogTable<Floats::kCount>;
#if HWY_TARGET == HWY_AVX3
  const Floats e = hn::Vec<Floats::Tag>{_mm512_getexp_ps(u.v.raw)};
  const Floats m =
      hn::Vec<Floats::Tag>{_mm512_getmant_ps(u.v.raw, _MM_MANT_NORM_1_2, _MM_MANT_SIGN_src)};
  const Words interval = shift_right<19>(bits_of(m));
#else
  const Words word = bits_of(u);
  const Floats e = to_floats(shift_right<23>(word)) - Floats(127);
  const Floats m = from_bits((word & Words(0x7FFFFFu)) | Words(0x3F800000u));
  const Words interval = shift_right<20>(word);
#endif
  const Floats inverse = permute(Floats::load(Table::kInverse), interval);
  const Floats log_c = permute(Floats::load(Table::kLog), interval);
  const Floats r = multiply_add(m, inverse, Floats(-1));
  // (log(1 + r) - r) / r^2 at Chebyshev's nodes: 2.1e-8 off log(1 + r)
#if HWY_TARGET == HWY_AVX3
  Floats p = multiply_add(r, Floats(-0.24112110582860555f), Floats(0.33351319221745496f));
  p = multiply_add(r, p, Floats(-0.5000042248572375f));
#else
  Floats p = multiply_add(r, Floats(0.18156326578121523f), Floats(-0.250497024600224f));
  p = multiply_add(r, p, Floats(0.3333975445715197f));
  p = multiply_add(r, p, Floats(-0.4999996941856882f));
#endif
  const Floats tail = multiply_add(r * r, p, r);
  return multiply_add(e, Floats(-0.693147180559945f), log_c) - tail;
#else
  return -log(u);
#endif
}

}  // namespace lamella::LAMELLA_ISA
