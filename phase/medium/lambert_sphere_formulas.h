#pragma once

#include <type_traits>

#include "phase/math/real.h"
#include "phase/math/sampling.h"

namespace lamella {

/// P in sin theta - theta cos theta = z^(3/2) P(z), z = 1 - cos theta in [0, 1], by a Chebyshev
/// series in powers of z: in double to rounding, in float to 3e-8.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real lambert_sphere_series(Real z) {
  if constexpr (std::is_same_v<typename NumberTraits<Real>::Scalar, double>) {
    constexpr double kPowers[] = {
        0.94280904158206339764,    0.047140452079085088805,   0.007576144085847242543,
        0.001753736992946836408,   4.8825758347713799073e-4,  1.5209590524875059299e-4,
        5.1240578082877007945e-5,  1.7535655724149018612e-5,  9.0900450277409957665e-6,
        -4.1012272981834591697e-6, 1.4830662884887576847e-5,  -2.0731762750676468985e-5,
        2.3760938238263254444e-5,  -1.8694133779466978139e-5, 1.0146519099585957918e-5,
        -3.3353687453253803356e-6, 5.2986482266038053179e-7};
    Real p(kPowers[16]);
    for (int k = 15; k >= 0; --k) p = multiply_add(p, z, Real(kPowers[k]));
    return p;
  } else {
    Real p = multiply_add(z, Real(2.380421156e-4), Real(-1.867968235e-4));
    p = multiply_add(z, p, Real(7.540276669e-4));
    p = multiply_add(z, p, Real(1.652281571e-3));
    p = multiply_add(z, p, Real(7.594096005e-3));
    p = multiply_add(z, p, Real(4.713927958e-2));
    return multiply_add(z, p, Real(9.428090540e-1));
  }
}

/// Phase function of a white Lambertian sphere by the cosine of the deflection, in [-1, 1]:
/// p = 2 (sin theta - theta cos theta) / (3 pi^2) [1/sr], theta = acos(cosine); p(1) = 0. Behind
/// the horizon p(cosine) = p(-cosine) - 2 cosine / (3 pi).
/// d'Eon 2021, "An analytic BRDF for materials with spherical Lambertian scatterers", eq. 1.
/// Relative error below 1e-12 (double); absolute error below 3e-8 / sr (lanes of float).
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real lambert_sphere_phase(Real cosine) {
  using std::abs, std::sqrt;
  const Real z = nonnegative(Real(1) - abs(cosine));
  const Real front = z * sqrt(z) * lambert_sphere_series(z);
  return Real(2 / (3 * kPi * kPi)) * multiply_add(nonnegative(-cosine), Real(kPi), front);
}
/// Exact sample of the deflection cosine from three uniforms in [0, 1) (d'Eon 2021, eq. 6, with
/// sin(pi (u3 - 1/2)) for sin(2 pi u3), which has the same distribution and a shorter series).
template <class Real>
[[nodiscard, gnu::always_inline]] inline Real lambert_sphere_cosine(Real u1, Real u2, Real u3) {
  using std::sqrt;
  const auto [s, c] = sine_cosine_near_zero((u3 - Real(0.5)) * Real(kPi / 2));
  return sqrt((Real(1) - u1) * (Real(1) - u2)) * (Real(2) * s * c) - sqrt(u1 * u2);
}

/// The deflection from one uniform number in (0, 1], monotone in it, so that with an azimuth two
/// numbers are a direction: 1 - cosine is w P(w), w the number's fourth root, P fitted so that the
/// cumulative probability is within 1.4e-6 of the number (also on lanes of float).
template <class Real>
[[nodiscard, gnu::always_inline]] inline SineCosine<Real> lambert_sphere_deflection(Real uniform) {
  using std::sqrt;
  const Real w = sqrt(sqrt(uniform)), t = multiply_add(w, Real(2), Real(-1));
  const Real p = polynomial(t, 1.358652089748903, 0.7904771656996334, -0.18863239089131484,
                            0.07520145294398145, -0.0479041401682353, -0.003407011773983726,
                            0.012876018456701166, 0.09623537214627387, -0.15616474034162486,
                            0.0006351052642408206, 0.11944401987415532, -0.057412166280201404);
  const Real below = min(w * p, Real(2));
  return {sqrt(nonnegative(below * (Real(2) - below))), Real(1) - below};
}

}  // namespace lamella
