#pragma once

#include "phase/math/direction.h"
#include "phase/math/real.h"

namespace lamella {

// The Fourier components of three_term_fourier (analytic/half_space/three_term.h) over any number
// type.

template <class Real>
[[nodiscard]] Real legendre_2(Real x) {
  return Real(1.5) * x * x - Real(0.5);
}

/// Mode 0: 1 / (4 pi) (w0 + w1 x y + w2 P_2(x) P_2(y)), from both products.
template <class Real>
[[nodiscard]] Real three_term_mean(double w0, double w1, double w2, Real product, Real legendres) {
  return multiply_add(Real(w2 / (4 * kPi)), legendres,
                      multiply_add(Real(w1 / (4 * kPi)), product, Real(w0 / (4 * kPi))));
}

/// Mode 1 over both sines: 1 / (4 pi) (w1 + 3 w2 x y), from the product.
template <class Real>
[[nodiscard]] Real three_term_slope(double w1, double w2, Real product) {
  return multiply_add(Real(3 * w2 / (4 * kPi)), product, Real(w1 / (4 * kPi)));
}

}  // namespace lamella
