#pragma once

#include <numbers>

namespace lamella {

template <class Real>
struct SineCosine {
  Real sine, cosine;
};

/// Sine and cosine of x in [-pi/4, pi/4]: the polynomials of fdlibm's k_sin.c and k_cos.c (Sun
/// Microsystems 1993). Absolute error below 1.5e-16 in double.
template <class Real>
[[nodiscard]] inline SineCosine<Real> sine_cosine_near_zero(Real x) {
  const Real z = x * x;
  const Real s = Real(-1.66666666666666324348e-01) +
                 z * (Real(8.33333333332248946124e-03) +
                      z * (Real(-1.98412698298579493134e-04) +
                           z * (Real(2.75573137070700676789e-06) +
                                z * (Real(-2.50507602534068634195e-08) +
                                     z * Real(1.58969099521155010221e-10)))));
  const Real c = Real(4.16666666666666019037e-02) +
                 z * (Real(-1.38888888888741095749e-03) +
                      z * (Real(2.48015872894767294178e-05) +
                           z * (Real(-2.75573143513906633035e-07) +
                                z * (Real(2.08757232129817482790e-09) -
                                     z * Real(1.13596475577881948265e-11)))));
  return {x + x * z * s, Real(1) - Real(0.5) * z + z * z * c};
}

/// Sine and cosine of pi u, u in [-1, 1]: a quarter of the angle, doubled twice, so that there are
/// no quadrants to tell apart. Absolute error below 2e-15 in double.
template <class Real>
[[nodiscard]] inline SineCosine<Real> sine_cosine_of_half_turns(Real u) {
  const auto [s1, c1] = sine_cosine_near_zero(u * Real(std::numbers::pi / 4));
  const Real s2 = Real(2) * s1 * c1;
  const Real c2 = Real(1) - Real(2) * s1 * s1;
  return {Real(2) * s2 * c2, Real(1) - Real(2) * s2 * s2};
}

/// Sine and cosine of 2 pi u, u in [0, 1].
template <class Real>
[[nodiscard]] inline SineCosine<Real> sine_cosine_of_turns(Real u) {
  // The angle is 2 pi u - pi: both change their sign.
  const auto [s, c] = sine_cosine_of_half_turns(Real(2) * (u - Real(0.5)));
  return {-s, -c};
}

}  // namespace lamella
