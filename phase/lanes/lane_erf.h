#pragma once

// The complementary error function on lanes of float. Only for sources of lamella_lanes(), see
// phase/lanes/lanes.h. The stated error is tested.

#include "phase/lanes/lanes.h"

namespace lamella::LAMELLA_ISA {

/// exp(x^2) erfc(x) for x >= 0: relative error below 8e-7. (1 + 2 x) times it is a polynomial in
/// (x - 2) / (x + 2) by Chebyshev interpolation, 7.3e-8 off (Shepherd and Laframboise 1981).
LAMELLA_INLINE Floats scaled_erfc(Floats x) {
  const Floats t = divide(x - Floats(2), x + Floats(2));
  const Floats g = polynomial(t, 1.276978382, -0.09276303881, -0.1660306043, 0.1640352733,
                              -0.05421590088, -0.007940706906, 0.008700217213, 0.001040480801,
                              -0.001408357749, -0.0001824780147, 0.0001658675793);
  return divide(g, multiply_add(Floats(2), x, Floats(1)));
}

}  // namespace lamella::LAMELLA_ISA
