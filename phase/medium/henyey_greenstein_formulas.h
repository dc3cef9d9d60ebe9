#pragma once

#include "phase/math/sampling.h"

namespace lamella {

/// Henyey-Greenstein phase function [1/sr] by the cosine of the deflection; g in (-1, 1) is its
/// mean, g > 0 scatters forward, 0 is isotropic.
/// (1 - g^2) / (4 pi (1 + g^2 - 2 g cosine)^(3/2)), the base written without cancellation.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real henyey_greenstein_phase(Real g, Real cosine) {
  using std::sqrt;
  // 1 + g^2 - 2 g cosine, written as (1 - |g|)^2 + 2 |g| (1 -+ cosine)
  const auto backward = g < Real(0);
  const Real a = select(backward, -g, g), c = select(backward, -cosine, cosine);
  const Real base = multiply_add(Real(2) * a, Real(1) - c, (Real(1) - a) * (Real(1) - a));
  return divide((Real(1) - g) * (Real(1) + g), Real(4 * kPi) * base * sqrt(base));
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

/// Likewise from a uniform in (0, 1).
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real henyey_greenstein_cosine(Real g, Real u) {
  return henyey_greenstein_cosine_signed(g, multiply_add(Real(2), u, Real(-1)));
}

}  // namespace lamella
