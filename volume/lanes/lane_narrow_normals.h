#pragma once

// Number types: lanes of float, and double. Domain: kappa >= kLeastNarrow, light for which
// kappa (1 - sqrt(1 - u^2)) >= kFacingExponent.
// Error: cumulative probabilities within kNarrowError of the distribution's own.
//
// Visible normals of narrow vMF flakes without tables, where no flake that matters turns its back
// to the light. The symbols are those of volume/lanes/lane_normals.h; t is 1 less the cosine of a
// normal with the mean normal a, phi its azimuth about a from the plane of w and a. With
// w.m = u (1 - t) (1 + e cos(phi)), where e is the tangent of the normal's angle with a times
// sqrt(1 - u^2) / u, the density exp(-kappa t) w.m factors into
//
//   p(t) ~ (1 - t) exp(-kappa t),   p(phi | t) = (1 + e cos(phi)) / (2 pi),
//
// as e is at most 1 for all t that matter. Both are inverted, each by one uniform number:
//
//   - The probability beyond t is exp(-kappa t) (1 - kappa t / (kappa - 1)) = exp(-E). Its inverse
//     is a power series of E, three terms of which are kept.
//   - phi + e sin(phi) = M, M uniform, is Kepler's equation. sin(d) = e sin(M - d) would be solved
//     by the angle d of (1 + e cos(M), e sin(M)), without trigonometric functions. phi = M - d is
//     then off by the residual d - sin(d) of the third order in e, which a step of Newton's removes
//     but for e^7 / 72.

#include <cmath>

#include "phase/math/vec3.h"
#include "phase/random/block_random.h"
#include "volume/lanes/lane_layers.h"

namespace lamella {

/// Of the domain, and the bound of the error named above.
inline constexpr double kLeastNarrow = 40, kFacingExponent = 28, kNarrowError = 1e-6;

/// The least u of the domain, or 2 where kappa is too small.
[[nodiscard]] inline double facing_cosine(double kappa) {
  if (!(kappa >= kLeastNarrow)) return 2;
  const double x = kFacingExponent / kappa;
  return std::sqrt(x * (2 - x));
}

/// Terms of t = E (first + E (second + E third)).
template <class Real>
struct TiltSeries {
  Real first, second, third;
};
[[nodiscard]] inline TiltSeries<double> tilt_series(double kappa) {
  const double first = (kappa - 1) / (kappa * kappa), second = -first / (2 * kappa * kappa);
  return {first, second, second * (2 * kappa - 3) / (3 * kappa * kappa)};
}

/// A normal in the frame whose z is the mean normal, for light from w in that frame, w.z = u.
template <class Real>
[[nodiscard]] LAMELLA_INLINE Vec3<Real> narrow_normal(const TiltSeries<Real>& tilt, Vec3<Real> w,
                                                      WordsOf<Real> word_of_tilt,
                                                      WordsOf<Real> word_of_azimuth) {
  const Real x = exponential_of(word_of_tilt);
  const Real t = x * multiply_add(x, multiply_add(x, tilt.third, tilt.second), tilt.first);
  const Real cosine = Real(1) - t, sine2 = t * (Real(2) - t);
  const Real sine = sine2 * reciprocal_sqrt(max(sine2, Real(1e-30)));
  // e cos(M) and e sin(M), M counted from the plane of w: the frame's azimuth is as uniform.
  const auto [s, c] = azimuth_of(word_of_azimuth);
  const Real steepness = sine * reciprocal(cosine * w.z);
  const Real along = steepness * multiply_add(c, w.x, s * w.y);
  const Real beside = steepness * multiply_add(s, w.x, -(c * w.y));
  const Real front = Real(1) + along;
  const Real inverse = reciprocal_sqrt(multiply_add(front, front, beside * beside));
  const Real d_cosine = front * inverse, d_sine = beside * inverse;
  const Real c1 = multiply_add(c, d_cosine, s * d_sine);
  const Real s1 = multiply_add(s, d_cosine, -(c * d_sine));
  // d - sin(d) over 1 + e cos(M - d) = 1 / inverse + 1 - cos(d).
  const Real q = d_sine * d_sine;
  const Real bend =
      multiply_add(q, multiply_add(inverse, Real(-1.0 / 12), Real(3.0 / 40)), Real(1.0 / 6));
  const Real rest = (d_sine * q) * (inverse * bend), half = Real(0.5) * rest;
  return {sine * multiply_add(-rest, multiply_add(half, c1, s1), c1),
          sine * multiply_add(rest, multiply_add(-half, s1, c1), s1), cosine};
}

}  // namespace lamella
