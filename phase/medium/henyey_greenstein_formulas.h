#pragma once

#include "phase/math/sampling.h"

namespace lamella {

/// Henyey-Greenstein phase function [1/sr] by how far the deflection's cosine is from that of the
/// peak: away = 1 - cosine for g >= 0, 1 + cosine for g < 0, in [0, 2]. g in (-1, 1) is the mean
/// cosine, g > 0 scatters forward, 0 is isotropic.
/// (1 - g^2) / (4 pi (1 + g^2 - 2 g cosine)^(3/2)) (Henyey and Greenstein 1941), the base written
/// as (1 - |g|)^2 + 2 |g| away: a few roundings for every g, as long as `away` has none.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real henyey_greenstein_phase_beside(Real g, Real away) {
  using std::sqrt;
  const Real a = select(g < Real(0), -g, g);
  const Real base = multiply_add(Real(2) * a, away, (Real(1) - a) * (Real(1) - a));
  return divide((Real(1) - g) * (Real(1) + g), Real(4 * kPi) * base * sqrt(base));
}

/// The Henyey-Greenstein phase function by the cosine of the deflection, in [-1, 1]. The cosine's
/// rounding counts for |g| near 1: a relative error of up to 2e-15 / (1 - |g|)^2 at the peak in
/// double.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real henyey_greenstein_phase(Real g, Real cosine) {
  const Real c = select(g < Real(0), -cosine, cosine);
  return henyey_greenstein_phase_beside(g, Real(1) - c);
}

/// Exact sample of the deflection cosine from a uniform x in [-1, 1]: the inverse of the cumulative
/// distribution, written so that g -> 0 needs no special case and rounding keeps it in [-1, 1].
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real henyey_greenstein_cosine_signed(Real g, Real x) {
  // (1 + g^2 - ((1 - g^2) / (1 + g x))^2) / (2 g), with the division by g carried out
  const Real d = multiply_add(g, x, Real(1)), g2 = g * g;
  const Real most = Real(1) + g2, half = Real(0.5) * g;
  return divide(multiply_add(x, multiply_add(x, half * most, most), half * (Real(3) - g2)), d * d);
}

/// The same sample from a uniform in (0, 1).
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real henyey_greenstein_cosine(Real g, Real u) {
  return henyey_greenstein_cosine_signed(g, multiply_add(Real(2), u, Real(-1)));
}

/// How far the deflection's cosine is from the peak's, by the same inverse from a uniform in (0,
/// 1), without cancellation for any g in (-1, 1): 1 - cosine for g >= 0, 1 + cosine for g < 0.
///   1 - cosine = 2 (1 - g)^2 (1 - u) (1 + g u) / (1 - g + 2 g u)^2,
/// and g < 0 mirrors it: cosine(g, u) = -cosine(-g, 1 - u).
[[nodiscard]] inline double henyey_greenstein_away(double g, double u) {
  const double a = g < 0 ? -g : g, v = g < 0 ? 1 - u : u;
  const double ratio = (1 - a) / (1 - a + 2 * a * v);
  return 2 * ratio * ratio * (1 - v) * (1 + a * v);
}

}  // namespace lamella
