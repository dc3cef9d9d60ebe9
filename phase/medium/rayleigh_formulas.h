#pragma once

#include "phase/math/sampling.h"

namespace lamella {

/// Rayleigh's phase function of unpolarised light [1/sr] by the cosine of the deflection:
/// 3 (1 + cosine^2) / (16 pi). Lord Rayleigh 1871; Chandrasekhar 1960, "Radiative Transfer",
/// sec. 3.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real rayleigh_phase(Real cosine) {
  return multiply_add(cosine, cosine, Real(1)) * Real(3 / (16 * kPi));
}

/// Exact sample of the deflection cosine from a uniform x in [-1, 1]. The cumulative distribution
/// is (cosine^3 + 3 cosine + 4) / 8, so that cosine^3 + 3 cosine = 4 x; Cardano's root is a - 1 / a
/// with a = (2 |x| + sqrt(4 x^2 + 1))^(1/3), taken for |x| so that nothing cancels under the root.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real rayleigh_cosine_signed(Real x) {
  using std::cbrt, std::sqrt, std::abs;
  const Real q = Real(2) * abs(x);
  const Real a = cbrt(q + sqrt(multiply_add(q, q, Real(1))));
  const Real cosine = min(a - divide(Real(1), a), Real(1));
  return select(x < Real(0), -cosine, cosine);
}

}  // namespace lamella
