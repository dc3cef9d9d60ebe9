#pragma once

// Lanes: as many numbers as one instruction works on. Only for sources that lamella_lanes() in the
// top CMakeLists.txt compiles once per instruction set, which defines LAMELLA_ISA as the set's
// name: everything here, and every template that the source instantiates with these types, then has
// that name in its symbol, and the linker cannot take a wide copy for a narrow machine. The source
// must use nothing of the standard library that is not a template over these types (a test reads
// its symbols). See phase/README.md.

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "phase/math/real.h"

#ifndef LAMELLA_ISA
#error "phase/lanes/lanes.h is for sources of lamella_lanes()"
#endif

namespace lamella::LAMELLA_ISA {

namespace hn = hwy::HWY_NAMESPACE;

/// A condition per lane.
template <class T>
struct Mask {
  using Tag = hn::ScalableTag<T>;
  hn::Mask<Tag> m;

  LAMELLA_INLINE friend Mask operator&(Mask a, Mask b) { return {hn::And(a.m, b.m)}; }
  LAMELLA_INLINE friend Mask operator|(Mask a, Mask b) { return {hn::Or(a.m, b.m)}; }
  LAMELLA_INLINE friend Mask operator^(Mask a, Mask b) { return {hn::Xor(a.m, b.m)}; }
  LAMELLA_INLINE friend Mask operator!(Mask a) { return {hn::Not(a.m)}; }
  LAMELLA_INLINE friend Mask without(Mask a, Mask b) { return {hn::AndNot(b.m, a.m)}; }
};

/// One register of numbers of type T: float, double (Floats, Doubles below) or std::uint32_t
/// (Words).
template <class T>
struct Lane {
  using Tag = hn::ScalableTag<T>;
  using Vector = hn::Vec<Tag>;
  static constexpr int kCount = HWY_LANES(T);
  using ScalarType = T;
  using MaskType = Mask<T>;
  using WordsType = Lane<std::uint32_t>;

  Vector v;

  Lane() = default;
  LAMELLA_INLINE Lane(Vector vector) : v(vector) {}
  /// The same number in every lane.
  template <class U>
  requires std::is_arithmetic_v<U> LAMELLA_INLINE explicit Lane(U x)
      : v(hn::Set(Tag(), static_cast<T>(x))) {}

  LAMELLA_INLINE friend Lane operator+(Lane a, Lane b) { return hn::Add(a.v, b.v); }
  LAMELLA_INLINE friend Lane operator-(Lane a, Lane b) { return hn::Sub(a.v, b.v); }
  LAMELLA_INLINE friend Lane operator*(Lane a, Lane b) { return hn::Mul(a.v, b.v); }
  LAMELLA_INLINE friend Lane operator/(Lane a, Lane b) { return hn::Div(a.v, b.v); }
  LAMELLA_INLINE friend Lane operator-(Lane a) { return hn::Neg(a.v); }
  LAMELLA_INLINE friend Lane operator^(Lane a, Lane b) { return hn::Xor(a.v, b.v); }
  LAMELLA_INLINE friend Lane operator&(Lane a, Lane b) { return hn::And(a.v, b.v); }
  LAMELLA_INLINE friend Lane operator|(Lane a, Lane b) { return hn::Or(a.v, b.v); }
  LAMELLA_INLINE friend Mask<T> operator<(Lane a, Lane b) { return {hn::Lt(a.v, b.v)}; }
  LAMELLA_INLINE friend Mask<T> operator>(Lane a, Lane b) { return {hn::Gt(a.v, b.v)}; }
  LAMELLA_INLINE friend Mask<T> operator<=(Lane a, Lane b) { return b >= a; }
  LAMELLA_INLINE friend Mask<T> operator>=(Lane a, Lane b) {
    if constexpr (std::is_floating_point_v<T>)
      return {hn::Ge(a.v, b.v)};
    else
      return !(a < b);
  }
  LAMELLA_INLINE friend Mask<T> equal(Lane a, Lane b) { return {hn::Eq(a.v, b.v)}; }

  LAMELLA_INLINE friend Lane select(Mask<T> condition, Lane a, Lane b) {
    return hn::IfThenElse(condition.m, a.v, b.v);
  }
  LAMELLA_INLINE friend Lane min(Lane a, Lane b) { return hn::Min(a.v, b.v); }
  LAMELLA_INLINE friend Lane max(Lane a, Lane b) { return hn::Max(a.v, b.v); }
  LAMELLA_INLINE friend Lane abs(Lane a) { return hn::Abs(a.v); }
  LAMELLA_INLINE friend Lane nonnegative(Lane a) { return hn::Max(a.v, hn::Zero(Tag())); }
  LAMELLA_INLINE friend Lane copysign(Lane a, Lane sign) { return hn::CopySign(a.v, sign.v); }
  LAMELLA_INLINE friend Lane multiply_add(Lane a, Lane b, Lane c) {
    return hn::MulAdd(a.v, b.v, c.v);
  }
  LAMELLA_INLINE friend Lane round(Lane a) { return hn::Round(a.v); }
  LAMELLA_INLINE friend Lane floor(Lane a) { return hn::Floor(a.v); }
  LAMELLA_INLINE friend Lane reciprocal(Lane a) {
    if constexpr (std::is_same_v<T, float>) {
      const Lane x = hn::ApproximateReciprocal(a.v);  // and one step of Newton's
      return x * hn::NegMulAdd(a.v, x.v, hn::Set(Tag(), 2));
    } else {
      return Lane(1) / a;
    }
  }
  LAMELLA_INLINE friend Lane reciprocal_sqrt(Lane a) {
    if constexpr (std::is_same_v<T, float>) {
      const Lane x = hn::ApproximateReciprocalSqrt(a.v);
      const Lane half = Lane(0.5f) * a * x;
      return x * hn::NegMulAdd(half.v, x.v, hn::Set(Tag(), 1.5f));
    } else {
      return Lane(1) / sqrt(a);
    }
  }
  LAMELLA_INLINE friend Lane divide(Lane a, Lane b) { return a * reciprocal(b); }
  LAMELLA_INLINE friend Lane sqrt(Lane a) { return hn::Sqrt(a.v); }

  /// Loads or stores one register of numbers, aligned or not.
  LAMELLA_INLINE static Lane load(const T* from) { return hn::LoadU(Tag(), from); }
  LAMELLA_INLINE void store(T* to) const { hn::StoreU(v, Tag(), to); }
  /// 0, 1, 2, ...
  LAMELLA_INLINE static Lane iota() { return hn::Iota(Tag(), T(0)); }
};

using Floats = Lane<float>;
using Doubles = Lane<double>;
using Words = Lane<std::uint32_t>;
using FloatMask = Mask<float>;
using WordMask = Mask<std::uint32_t>;

LAMELLA_INLINE Words operator<<(Words a, int n) { return hn::ShiftLeftSame(a.v, n); }
LAMELLA_INLINE Words operator>>(Words a, int n) { return hn::ShiftRightSame(a.v, n); }
template <int n>
LAMELLA_INLINE Words shift_right(Words a) {
  return hn::ShiftRight<n>(a.v);
}
template <int n>
LAMELLA_INLINE Words shift_left(Words a) {
  return hn::ShiftLeft<n>(a.v);
}

/// a ^ b ^ c: one instruction with AVX-512.
LAMELLA_INLINE Words xor_of(Words a, Words b, Words c) { return hn::Xor3(a.v, b.v, c.v); }

/// a < b, both below 2^31: one instruction where there is no comparison of unsigned numbers.
LAMELLA_INLINE WordMask is_below(Words a, Words b) {
  const hn::ScalableTag<std::int32_t> d;
  return {hn::RebindMask(WordMask::Tag(), hn::Lt(hn::BitCast(d, a.v), hn::BitCast(d, b.v)))};
}

/// 0 <= a <= limit, where a is not -0: by one comparison of bits, of which those of negative
/// numbers are the largest, where there is one of unsigned numbers.
LAMELLA_INLINE FloatMask is_within(Floats a, Floats limit) {
#if HWY_TARGET == HWY_AVX3
  return {hn::Mask<FloatMask::Tag>{
      _mm512_cmple_epu32_mask(_mm512_castps_si512(a.v.raw), _mm512_castps_si512(limit.v.raw))}};
#else
  return (Floats(0) <= a) & (a <= limit);
#endif
}

template <int n>
LAMELLA_INLINE Words rotate_left(Words a) {
  return hn::RotateRight<32 - n>(a.v);
}

LAMELLA_INLINE FloatMask to_float_mask(WordMask a) {
  return {hn::RebindMask(FloatMask::Tag(), a.m)};
}
LAMELLA_INLINE WordMask to_word_mask(FloatMask a) { return {hn::RebindMask(WordMask::Tag(), a.m)}; }

/// The bits of a number, and back.
LAMELLA_INLINE Words bits_of(Floats a) { return hn::BitCast(Words::Tag(), a.v); }
LAMELLA_INLINE Floats from_bits(Words a) { return hn::BitCast(Floats::Tag(), a.v); }
/// Numbers below 2^31 as floats.
LAMELLA_INLINE Floats to_floats(Words a) {
  return hn::ConvertTo(Floats::Tag(), hn::BitCast(hn::ScalableTag<std::int32_t>(), a.v));
}
/// Rounded towards 0; below 2^31 in size, negative numbers as two's complement. (Highway's
/// conversions take four more instructions to saturate.)
LAMELLA_INLINE Words to_words(Floats a) {
#if HWY_TARGET == HWY_AVX3
  return hn::Vec<Words::Tag>{_mm512_cvttps_epi32(a.v.raw)};
#elif HWY_TARGET == HWY_AVX2
  return hn::Vec<Words::Tag>{_mm256_cvttps_epi32(a.v.raw)};
#else
  return hn::Vec<Words::Tag>{_mm_cvttps_epi32(a.v.raw)};
#endif
}
/// The same conversion, rounded to nearest.
LAMELLA_INLINE Words to_nearest_words(Floats a) {
#if HWY_TARGET == HWY_AVX3
  return hn::Vec<Words::Tag>{_mm512_cvtps_epi32(a.v.raw)};
#elif HWY_TARGET == HWY_AVX2
  return hn::Vec<Words::Tag>{_mm256_cvtps_epi32(a.v.raw)};
#else
  return hn::Vec<Words::Tag>{_mm_cvtps_epi32(a.v.raw)};
#endif
}

template <class T>
LAMELLA_INLINE bool any(Mask<T> a) {
  return !hn::AllFalse(typename Mask<T>::Tag(), a.m);
}
template <class T>
LAMELLA_INLINE int count(Mask<T> a) {
  return static_cast<int>(hn::CountTrue(typename Mask<T>::Tag(), a.m));
}
/// The condition of lane k in bit k.
template <class T>
LAMELLA_INLINE std::uint32_t mask_bits(Mask<T> a) {
#if HWY_TARGET == HWY_AVX3
  return static_cast<std::uint32_t>(a.m.raw);
#else
  return static_cast<std::uint32_t>(hn::detail::BitsFromMask(a.m));
#endif
}
template <class T>
LAMELLA_INLINE Mask<T> first_lanes(int n) {
  return {hn::FirstN(typename Mask<T>::Tag(), static_cast<std::size_t>(n))};
}

/// Lane k is lane index[k] of a.
template <class T>
LAMELLA_INLINE Lane<T> permute(Lane<T> a, Words index) {
  const typename Lane<T>::Tag d;
  return hn::TableLookupLanes(
      a.v, hn::IndicesFromVec(d, hn::BitCast(hn::ScalableTag<std::int32_t>(), index.v)));
}

#if HWY_TARGET != HWY_AVX3
namespace detail {
// For each set of chosen lanes: how many chosen lanes are below each lane, and which they are.
// Highway's own Compress copies its table to the stack at every use.
struct LaneTables {
  std::uint8_t rank[1 << Floats::kCount][8], chosen[1 << Floats::kCount][8];
};
constexpr LaneTables make_tables() {
  LaneTables table{};
  for (int b = 0; b < 1 << Floats::kCount; ++b)
    for (int k = 0, rank = 0; k < Floats::kCount; ++k) {
      table.rank[b][k] = static_cast<std::uint8_t>(rank);
      if ((b >> k) & 1) table.chosen[b][rank++] = static_cast<std::uint8_t>(k);
    }
  return table;
}
inline constexpr LaneTables kTables = make_tables();

LAMELLA_INLINE Words words_from(const std::uint8_t* bytes) {
  const hn::Rebind<std::uint8_t, Words::Tag> d;
  return hn::PromoteTo(Words::Tag(), hn::LoadU(d, bytes));
}
}  // namespace detail
#endif

/// Stores the lanes where the condition holds, one after the other; writes all kCount places. The
/// caller counts.
template <class T, class M>
LAMELLA_INLINE void store_compressed(Lane<T> a, Mask<M> condition, T* to) {
#if HWY_TARGET == HWY_AVX3
  const auto mask = hn::RebindMask(typename Lane<T>::Tag(), condition.m);
  hn::StoreU(hn::Compress(a.v, mask), typename Lane<T>::Tag(), to);
#else
  permute(a, detail::words_from(detail::kTables.chosen[mask_bits(condition)])).store(to);
#endif
}

/// For the lanes where the condition holds: 0 for the first of them, 1 for the next, ...; for the
/// others any number below kCount.
template <class T>
LAMELLA_INLINE Words rank_of(Mask<T> a) {
#if HWY_TARGET == HWY_AVX3
  return hn::Vec<Words::Tag>{
      _mm512_maskz_expand_epi32(static_cast<__mmask16>(a.m.raw), Words::iota().v.raw)};
#else
  return detail::words_from(detail::kTables.rank[mask_bits(a)]);
#endif
}

/// The names that formulas for any number type use, see phase/math/real.h.
LAMELLA_INLINE Floats number_of(Words a) { return to_floats(a); }
LAMELLA_INLINE Words word_of(Floats a) { return to_words(a); }

LAMELLA_INLINE Words highest_bit(Words a) {
  return shift_right<23>(bits_of(to_floats(a))) - Words(127u);
}
/// 2^place
LAMELLA_INLINE Floats power_of_two(Words place) {
  return from_bits(shift_left<23>(place + Words(127u)));
}
LAMELLA_INLINE Words word_with_bit(Words place) { return to_words(power_of_two(place)); }

/// table[index] per lane, of 16 numbers; of the index its last four bits count.
LAMELLA_INLINE Floats lookup(const float* table, Words index) {
  constexpr int n = Floats::kCount;
  if constexpr (n == 16) {
    return permute(Floats::load(table), index);
  } else if constexpr (n == 8) {
    const Words low = index & Words(7u);
    return select(to_float_mask(equal(index & Words(8u), Words(0u))),
                  permute(Floats::load(table), low), permute(Floats::load(table + n), low));
  } else {
    alignas(16) std::uint32_t at[n];
    alignas(16) float found[n];
    (index & Words(15u)).store(at);
    for (int k = 0; k < n; ++k) found[k] = table[at[k]];
    return Floats::load(found);
  }
}

/// table[index] per lane.
LAMELLA_INLINE Floats gather(const float* table, Words index) {
  return hn::GatherIndex(Floats::Tag(), table,
                         hn::BitCast(hn::ScalableTag<std::int32_t>(), index.v));
}

/// table[index] and table[index + 1] per lane: half as many loads as two gathers take.
LAMELLA_INLINE NumberPair<Floats> gather_pair(const float* table, Words index) {
#if HWY_TARGET == HWY_AVX3
  const __m512i at = index.v.raw;
  const __m512 lower = _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_castsi512_si256(at), table, 4));
  const __m512 upper =
      _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_extracti64x4_epi64(at, 1), table, 4));
  const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  const __m512i odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
  return {Floats(hn::Vec<Floats::Tag>{_mm512_permutex2var_ps(lower, even, upper)}),
          Floats(hn::Vec<Floats::Tag>{_mm512_permutex2var_ps(lower, odd, upper)})};
#else
  return {gather(table, index), gather(table + 1, index)};
#endif
}

}  // namespace lamella::LAMELLA_ISA
