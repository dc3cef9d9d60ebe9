#pragma once

// Elementary functions on lanes of float: the polynomials, without tables and branches. Only for
// sources of lamella_lanes(), see phase/lanes/lanes.h. The stated errors are tested.

#include "phase/lanes/lanes.h"
#include "phase/math/trigonometry.h"

namespace lamella::LAMELLA_ISA {

/// Sine and cosine of x in [-pi/4, pi/4]: absolute error below 1.2e-7. Minimax polynomials of the
/// Cephes library (Moshier 1992), single precision.
LAMELLA_INLINE SineCosine<Floats> sine_cosine_near_zero(Floats x) {
  const Floats z = x * x;
  Floats s = multiply_add(z, Floats(-1.9515295891e-4f), Floats(8.3321608736e-3f));
  s = multiply_add(z, s, Floats(-1.6666654611e-1f));
  Floats c = multiply_add(z, Floats(2.443315711809948e-5f), Floats(-1.388731625493765e-3f));
  c = multiply_add(z, c, Floats(4.166664568298827e-2f));
  return {multiply_add(x * z, s, x),
          multiply_add(z * z, c, multiply_add(z, Floats(-0.5f), Floats(1)))};
}

/// Sine and cosine of twice `half`, which is in [-pi/2, pi/2]: absolute error below 6e-7. Those of
/// `half` by Chebyshev interpolation in its square (2.7e-8 off before rounding), doubled.
LAMELLA_INLINE SineCosine<Floats> sine_cosine_of_twice(Floats half) {
  const Floats z = half * half;
  Floats s = multiply_add(z, Floats(2.634756392e-06f), Floats(-0.0001982273949f));
  s = multiply_add(z, s, Floats(0.008333242135f));
  s = multiply_add(z, s, Floats(-0.1666666596f));
  Floats c = multiply_add(z, Floats(-2.629751743e-07f), Floats(2.477457975e-05f));
  c = multiply_add(z, c, Floats(-0.001388865165f));
  c = multiply_add(z, c, Floats(0.04166665936f));
  c = multiply_add(z, c, Floats(-0.4999999996f));
  const Floats sine = multiply_add(half * z, s, half), cosine = multiply_add(z, c, Floats(1));
  const Floats twice = sine + sine;
  return {twice * cosine, multiply_add(-twice, sine, Floats(1))};
}
/// Of pi u, u in [-1, 1].
LAMELLA_INLINE SineCosine<Floats> sine_cosine_of_half_turns(Floats u) {
  return sine_cosine_of_twice(u * Floats(1.57079632679489662f));
}

/// log(x) for normal x > 0: absolute error below 1.2e-7 max(1, |log x|), relative error below 3e-7
/// near x = 1. Polynomial of the Cephes library.
LAMELLA_INLINE Floats log(Floats x) {
  // x = 2^e m, m in [sqrt(1/2), sqrt(2))
  const Words shifted = bits_of(x) - Words(0x3f3504f3u);
  const hn::ScalableTag<std::int32_t> signed_tag;
  const auto exponent = hn::ShiftRight<23>(hn::BitCast(signed_tag, shifted.v));
  const Floats e = hn::ConvertTo(Floats::Tag(), exponent);
  const Words mantissa = bits_of(x) - Words(hn::BitCast(Words::Tag(), hn::ShiftLeft<23>(exponent)));
  const Floats f = from_bits(mantissa) - Floats(1);
  Floats p = multiply_add(f, Floats(7.0376836292e-2f), Floats(-1.1514610310e-1f));
  p = multiply_add(f, p, Floats(1.1676998740e-1f));
  p = multiply_add(f, p, Floats(-1.2420140846e-1f));
  p = multiply_add(f, p, Floats(1.4249322787e-1f));
  p = multiply_add(f, p, Floats(-1.6668057665e-1f));
  p = multiply_add(f, p, Floats(2.0000714765e-1f));
  p = multiply_add(f, p, Floats(-2.4999993993e-1f));
  p = multiply_add(f, p, Floats(3.3333331174e-1f));
  const Floats f2 = f * f;
  const Floats tail = multiply_add(f2, multiply_add(f, p, Floats(-0.5f)), f);
  return multiply_add(e, Floats(0.693147180559945f), tail);
}

/// exp(x) for x <= 88: relative error below 2e-7; 0 below -87.
LAMELLA_INLINE Floats exp(Floats x) {
  // Rounded to an integer in its last places by a number whose last place is 1.
  const Floats magic(0x1.8p23f);
  const Floats shifted = multiply_add(x, Floats(1.44269504088896341f), magic);
  const Floats n = shifted - magic;
  Floats r = multiply_add(n, Floats(-0.693359375f), x);
  r = multiply_add(n, Floats(2.12194440e-4f), r);
  Floats p = multiply_add(r, Floats(1.9875691500e-4f), Floats(1.3981999507e-3f));
  p = multiply_add(r, p, Floats(8.3334519073e-3f));
  p = multiply_add(r, p, Floats(4.1665795894e-2f));
  p = multiply_add(r, p, Floats(1.6666665459e-1f));
  p = multiply_add(r, p, Floats(5.0000001201e-1f));
  const Floats value = multiply_add(r * r, p, r + Floats(1));
  // times 2^n, n in [-126, 127] wherever the result is taken
  const Floats scaled = from_bits(bits_of(value) + shift_left<23>(bits_of(shifted)));
  return select(x < Floats(-87), Floats(0), scaled);
}

/// Cube root of x in [1e-30, 1e30]: relative error below 4e-7. A guess of x^(-1/3) from the bits,
/// 4 % off, and two steps of Householder's.
LAMELLA_INLINE Floats cbrt(Floats x) {
  Floats y = from_bits(Words(0x54a21d2au) - to_words(to_floats(bits_of(x)) * Floats(1.0f / 3)));
  for (int k = 0; k < 2; ++k) {
    const Floats h = Floats(1) - x * (y * y * y);
    y = multiply_add(y * h, multiply_add(h, Floats(2.0f / 9), Floats(1.0f / 3)), y);
  }
  return x * (y * y);
}

/// Angle of (x, y) as a fraction of a turn in [0, 1): absolute error below 5e-8 turns. At the
/// origin 0. The arc tangent's polynomial is a truncated Chebyshev series, 3e-9 off.
LAMELLA_INLINE Floats turns_of(Floats y, Floats x) {
  const Floats ax = abs(x), ay = abs(y);
  const Floats larger = max(ax, ay), smaller = min(ax, ay);
  const Floats t = divide(smaller, max(larger, Floats(1e-37f)));
  const Floats z = t * t;
  // atan(t) / (2 pi t)
  Floats p = multiply_add(z, Floats(4.510553438e-04f), Floats(-2.547279725e-03f));
  p = multiply_add(z, p, Floats(6.778028252e-03f));
  p = multiply_add(z, p, Floats(-1.192937194e-02f));
  p = multiply_add(z, p, Floats(1.692891994e-02f));
  p = multiply_add(z, p, Floats(-2.260409302e-02f));
  p = multiply_add(z, p, Floats(3.181902586e-02f));
  p = multiply_add(z, p, Floats(-5.305122347e-02f));
  p = multiply_add(z, p, Floats(1.591549406e-01f));
  Floats turns = p * t;
  turns = select(ay > ax, Floats(0.25f) - turns, turns);
  turns = select(x < Floats(0), Floats(0.5f) - turns, turns);
  turns = select(y < Floats(0), Floats(1) - turns, turns);
  return select(turns < Floats(1), turns, Floats(0));
}

}  // namespace lamella::LAMELLA_ISA
