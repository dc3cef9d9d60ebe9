#pragma once

// Elementary functions on lanes of double, without tables and branches, for formulas that are
// templates over their number type (phase/math/real.h). Only for sources of lamella_lanes(), see
// phase/lanes/lanes.h. The stated errors are tested.

#include "phase/lanes/lanes.h"
#include "phase/math/real.h"
#include "phase/math/trigonometry.h"

namespace lamella::LAMELLA_ISA {

using LongWords = Lane<std::uint64_t>;
using DoubleMask = Mask<double>;

LAMELLA_INLINE LongWords long_bits_of(Doubles a) { return hn::BitCast(LongWords::Tag(), a.v); }
LAMELLA_INLINE Doubles from_long_bits(LongWords a) { return hn::BitCast(Doubles::Tag(), a.v); }

/// log(x) for normal x > 0: relative error below 4e-16. The polynomial of fdlibm's e_log.c (Sun
/// Microsystems 1993).
LAMELLA_INLINE Doubles log(Doubles x) {
  // x = 2^e m, m in [sqrt(1/2), sqrt(2)): `shifted` is the bits of x / sqrt(1/2) but for the
  // mantissa's unit.
  constexpr std::uint64_t kRoot = 0x3fe6a09e00000000u, kOne = 0x3ff0000000000000u;
  const LongWords shifted = long_bits_of(x) + LongWords(kOne - kRoot);
  // An integer below 2^52 in the low bits of 2^52.
  const LongWords exponent{hn::ShiftRight<52>(shifted.v)};
  const Doubles e =
      from_long_bits(exponent | LongWords(0x4330000000000000u)) - Doubles(0x1p52 + 1023);
  const Doubles m = from_long_bits((shifted & LongWords(0x000fffffffffffffu)) + LongWords(kRoot));
  const Doubles f = m - Doubles(1), s = f / (m + Doubles(1)), z = s * s,
                half = Doubles(0.5) * f * f;
  const Doubles r =
      z * polynomial(z, 6.666666666666735130e-01, 3.999999999940941908e-01,
                     2.857142874366239149e-01, 2.222219843214978396e-01, 1.818357216161805012e-01,
                     1.531383769920937332e-01, 1.479819860510658591e-01);
  const Doubles low = multiply_add(s, half + r, e * Doubles(1.90821492927058770002e-10));
  return multiply_add(e, Doubles(6.93147180369123816490e-01), f - (half - low));
}

/// exp(x) for x <= 709: relative error below 4e-16; 0 below -708. The polynomial is a Chebyshev
/// interpolation, 4e-18 off.
LAMELLA_INLINE Doubles exp(Doubles x) {
  const Doubles n = round(x * Doubles(1.44269504088896340736));
  Doubles r = multiply_add(n, Doubles(-6.93147180369123816490e-01), x);
  r = multiply_add(n, Doubles(-1.90821492927058770002e-10), r);
  const Doubles p =
      polynomial(r, 1.0, 1.0, 5.00000000000001887e-01, 1.66666666666666796e-01,
                 4.16666666664866625e-02, 8.33333333331949012e-03, 1.38888889526965161e-03,
                 1.98412698903406662e-04, 2.48014850741051154e-05, 2.75572406046638965e-06,
                 2.76327905421171791e-07, 2.51101536469289312e-08);
  // n + 1023 in the low bits of 1.5 2^52, moved to where the exponent stands.
  const LongWords power{hn::ShiftLeft<52>(long_bits_of(n + Doubles(0x1.8p52 + 1023)).v)};
  return select(x < Doubles(-708), Doubles(0), p * from_long_bits(power));
}

/// x^y for normal x > 0: relative error below 4e-16 (2 + |y log x|).
LAMELLA_INLINE Doubles pow(Doubles x, Doubles y) { return exp(y * log(x)); }

/// asin(x) for x in [0, 0.708]: relative error below 4e-16. The polynomial is a Chebyshev
/// interpolation in z = x^2, 3e-17 off; even and odd powers apart, as two chains of operations.
LAMELLA_INLINE Doubles arc_sine_below_half_right(Doubles x) {
  const Doubles z = x * x, z2 = z * z;
  const Doubles even =
      polynomial(z2, 1.0, 7.50000000044257209e-02, 3.03819651518116331e-02, 1.73652465176531157e-02,
                 1.33139346818610185e-02, 8.33705749142932689e-02, 1.06563432232859290e+00,
                 4.86639063645792191e+00, 5.98335703169823585e+00, 9.15144700476989703e-01);
  const Doubles odd =
      polynomial(z2, 1.66666666666648089e-01, 4.46428567257261613e-02, 2.23715341260220316e-02,
                 1.37906316427651512e-02, -3.47428300161938724e-03, -3.15658765035826627e-01,
                 -2.62288563476629166e+00, -6.50249546807951173e+00, -3.39175633226456474e+00);
  return x * multiply_add(z, odd, even);
}

/// phase/math/real.h: arc_sine, angle_of. Relative error below 5e-16.
LAMELLA_INLINE Doubles arc_sine(Doubles sine, Doubles cosine) {
  const Doubles a = arc_sine_below_half_right(min(sine, cosine));
  return select(sine > cosine, Doubles(1.57079632679489661923) - a, a);
}
LAMELLA_INLINE Doubles angle_of(Doubles sine, Doubles cosine) {
  const Doubles c = abs(cosine);
  const Doubles acute = arc_sine(sine, c);
  return select(cosine < Doubles(0), Doubles(3.14159265358979323846) - acute, acute);
}

/// cos(x) for |x| <= 100: absolute error below 4e-16. Quadrants by Cody and Waite.
LAMELLA_INLINE Doubles cos(Doubles x) {
  const Doubles n = round(x * Doubles(0.636619772367581343076));
  Doubles r = multiply_add(n, Doubles(-1.57079632673412561417), x);
  r = multiply_add(n, Doubles(-6.07710050650619224932e-11), r);
  const auto [s, c] = sine_cosine_near_zero(r);
  const LongWords quadrant = long_bits_of(n + Doubles(0x1.8p52));
  const auto odd = equal(quadrant & LongWords(1u), LongWords(1u));
  const auto minus = equal((quadrant + LongWords(1u)) & LongWords(2u), LongWords(2u));
  const Doubles value = select({hn::RebindMask(Doubles::Tag(), odd.m)}, s, c);
  return select({hn::RebindMask(Doubles::Tag(), minus.m)}, -value, value);
}

/// erf(x), infinity included: absolute error below 9e-16 (of exp and four roundings). erfc(x) =
/// exp(-x^2) g(t) / (1 + 2 x), t = (x - 3.75) / (x + 3.75), with g by Chebyshev interpolation,
/// 6e-17 off (Shepherd and Laframboise 1981, "Chebyshev approximation of (1 + 2x) exp(x^2) erfc
/// x").
LAMELLA_INLINE Doubles erf(Doubles x) {
  const Doubles a = min(abs(x), Doubles(26));
  const Doubles t = (a - Doubles(3.75)) / (a + Doubles(3.75));
  const Doubles g =
      polynomial(t, 1.23751263083782748e+00, -1.40240598585547022e-01, 3.58541548547957516e-03,
                 8.22767384901497700e-02, -1.08803930142466448e-01, 9.23043211602589397e-02,
                 -5.86933985763106111e-02, 2.83622774203773353e-02, -9.74657968596217943e-03,
                 1.75562584343185715e-03, 2.93714390578893216e-04, -2.90154042033489740e-04,
                 5.16464934099065601e-05, 2.23841385255342826e-05, -1.14379803742394746e-05,
                 -9.73387516492805991e-07, 1.74190119417683432e-06, -5.74107610734765185e-08,
                 -2.48511086218980002e-07, 2.33985345967754718e-08, 3.19539859889881796e-08,
                 -3.79818992960855910e-09, -2.61852013020764025e-09, 3.20526260144817473e-10);
  const Doubles tail = exp(-a * a) * g / multiply_add(Doubles(2), a, Doubles(1));
  return copysign(Doubles(1) - tail, x);
}

}  // namespace lamella::LAMELLA_ISA
