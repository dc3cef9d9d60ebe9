#pragma once

// What formulas use besides + - * /, for double; phase/lanes/lanes.h has the same names for lanes.
// A formula that is a template over its number type and has `select` for branches is then written
// once: its double is the reference, its lanes are fast. Everything here is inlined and leaves no
// function of its own in the object, so that sources of lamella_lanes() may include it.

#include <cmath>
#include <concepts>
#include <cstdint>

#define LAMELLA_INLINE [[gnu::always_inline]] inline
/// Forces a lambda inline; stands after its parameters.
#define LAMELLA_INLINE_LAMBDA __attribute__((always_inline))

namespace lamella {

/// The types that go with a number type: its conditions, its 32-bit words, its elements.
template <class Real>
struct NumberTraits {
  using Mask = typename Real::MaskType;
  using Words = typename Real::WordsType;
  using WordMask = typename Words::MaskType;
  using Scalar = typename Real::ScalarType;
};
template <std::floating_point Real>
struct NumberTraits<Real> {
  using Mask = bool;
  using Words = std::uint32_t;
  using WordMask = bool;
  using Scalar = Real;
};
template <class Real>
using MaskOf = typename NumberTraits<Real>::Mask;
template <class Real>
using WordsOf = typename NumberTraits<Real>::Words;

LAMELLA_INLINE std::uint32_t select(bool condition, std::uint32_t a, std::uint32_t b) {
  return condition ? a : b;
}
LAMELLA_INLINE std::uint32_t min(std::uint32_t a, std::uint32_t b) { return a < b ? a : b; }
LAMELLA_INLINE std::uint32_t max(std::uint32_t a, std::uint32_t b) { return a > b ? a : b; }

/// a where the condition holds, else b; both are evaluated.
template <std::floating_point Real>
LAMELLA_INLINE Real select(bool condition, Real a, Real b) {
  return condition ? a : b;
}
template <std::floating_point Real>
LAMELLA_INLINE Real min(Real a, Real b) {
  return a < b ? a : b;
}
template <std::floating_point Real>
LAMELLA_INLINE Real max(Real a, Real b) {
  return a > b ? a : b;
}
/// The larger of a and 0; 0 for what is not a number.
template <std::floating_point Real>
LAMELLA_INLINE Real nonnegative(Real a) {
  return a > 0 ? a : 0;
}
/// a b + c, on lanes rounded once where the instruction set can.
template <std::floating_point Real>
LAMELLA_INLINE Real multiply_add(Real a, Real b, Real c) {
  return a * b + c;
}
/// The angle in [0, pi] with that sine, not negative, and that cosine, whose squares add up to 1.
template <std::floating_point Real>
LAMELLA_INLINE Real angle_of(Real sine, Real cosine) {
  return std::atan2(std::abs(sine), cosine);  // -0 is 0
}
/// The angle in [0, pi/2] with that sine and that cosine.
template <std::floating_point Real>
LAMELLA_INLINE Real arc_sine(Real sine, Real /*cosine*/) {
  return std::asin(sine);
}
/// c0 + x (c1 + x (c2 + ...)).
template <class Real>
LAMELLA_INLINE Real polynomial(Real /*x*/, double c0) {
  return Real(c0);
}
template <class Real, class... Rest>
LAMELLA_INLINE Real polynomial(Real x, double c0, Rest... rest) {
  return multiply_add(x, polynomial(x, rest...), Real(c0));
}
/// On lanes of float an approximation and a step of Newton's: relative error below 3e-7.
LAMELLA_INLINE double reciprocal(double a) { return 1 / a; }
LAMELLA_INLINE double reciprocal_sqrt(double a) { return 1 / std::sqrt(a); }
LAMELLA_INLINE double divide(double a, double b) { return a / b; }
LAMELLA_INLINE bool equal(double a, double b) { return a == b; }
LAMELLA_INLINE bool equal(std::uint32_t a, std::uint32_t b) { return a == b; }
LAMELLA_INLINE std::uint32_t xor_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return a ^ b ^ c;
}
/// a < b, both below 2^31.
LAMELLA_INLINE bool is_below(std::uint32_t a, std::uint32_t b) { return a < b; }
/// 0 <= a <= limit.
LAMELLA_INLINE bool is_within(double a, double limit) { return 0 <= a && a <= limit; }
LAMELLA_INLINE bool any(bool a) { return a; }
/// a and not b
LAMELLA_INLINE bool without(bool a, bool b) { return a && !b; }

LAMELLA_INLINE bool to_float_mask(bool a) { return a; }
LAMELLA_INLINE bool to_word_mask(bool a) { return a; }
/// Words below 2^31 as numbers, and numbers as words, rounded towards 0.
LAMELLA_INLINE double number_of(std::uint32_t a) { return a; }
LAMELLA_INLINE std::uint32_t word_of(double a) {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(a));
}
template <int n>
LAMELLA_INLINE std::uint32_t shift_left(std::uint32_t a) {
  return a << n;
}
template <int n>
LAMELLA_INLINE std::uint32_t shift_right(std::uint32_t a) {
  return a >> n;
}

/// The place of the highest bit of a word from 1 to 2^24; and the word whose only bit is at a
/// place, at most 30.
LAMELLA_INLINE std::uint32_t highest_bit(std::uint32_t a) {
  return 31u - static_cast<std::uint32_t>(__builtin_clz(a));
}
LAMELLA_INLINE std::uint32_t word_with_bit(std::uint32_t place) { return 1u << place; }

/// table[index] of 16 numbers; of the index its last four bits count.
LAMELLA_INLINE double lookup(const double* table, std::uint32_t index) { return table[index & 15]; }
LAMELLA_INLINE double gather(const float* table, std::uint32_t index) {
  return static_cast<double>(table[index]);
}
/// table[index] and table[index + 1].
template <class Real>
struct NumberPair {
  Real first, second;
};
LAMELLA_INLINE NumberPair<double> gather_pair(const float* table, std::uint32_t index) {
  return {gather(table, index), gather(table, index + 1)};
}

}  // namespace lamella
