#pragma once

#include "phase/math/direction.h"
#include "phase/math/trigonometry.h"

namespace lamella {

/// Uniform point of the unit sphere from two uniforms in (0, 1).
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> uniform_sphere(Real u1, Real u2) {
  using std::sqrt;
  const Real z = Real(1) - Real(2) * u1;
  const Real r = Real(2) * sqrt(u1 * (Real(1) - u1));
  const auto [sine, cosine] = sine_cosine_of_turns(u2);
  return {r * cosine, r * sine, z};
}

/// A uniform point of the sphere from its z, uniform in [-1, 1], and a uniform azimuth.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> sphere_point(Real z, SineCosine<Real> azimuth) {
  using std::sqrt;
  const Real r = sqrt(multiply_add(-z, z, Real(1)));
  return {r * azimuth.cosine, r * azimuth.sine, z};
}

/// Direction about the unit vector n with density cos / pi: the normalised sum of n and a uniform
/// point of the sphere (Lambert's law needs no frame). At the antipode itself, n.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> cosine_hemisphere(Vec3<Real> n, Real u1,
                                                                      Real u2) {
  const Vec3<Real> v = n + uniform_sphere(u1, u2);
  const Real l2 = dot(v, v);
  return select(l2 > Real(0), reciprocal_sqrt(l2) * v, n);
}

/// The direction at that polar angle from the unit vector axis, in the frame of frame_around(axis)
/// at the azimuth with that sine and cosine. Rounding moves it by 2e-16, however small the sine is.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> deflect(Vec3<Real> axis, SineCosine<Real> polar,
                                                            SineCosine<Real> azimuth) {
  using std::copysign;
  // The frame's vectors times the local coordinates, multiplied out.
  const Real sign = copysign(Real(1), axis.z);
  const Real x = polar.sine * azimuth.cosine, y = polar.sine * azimuth.sine;
  const Real flat = multiply_add(sign * x, axis.x, y * axis.y);
  const Real along = polar.cosine - flat * reciprocal(sign + axis.z);
  return renormalized(Vec3<Real>{multiply_add(axis.x, along, x),
                                 multiply_add(axis.y, along, sign * y),
                                 polar.cosine * axis.z - flat});
}

/// The same direction, by the polar angle's cosine alone.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> deflect(Vec3<Real> axis, Real cosine,
                                                            SineCosine<Real> azimuth) {
  using std::sqrt;
  const Real s = sqrt(nonnegative(multiply_add(-cosine, cosine, Real(1))));
  return deflect(axis, SineCosine<Real>{s, cosine}, azimuth);
}

/// The same deflection at the azimuth 2 pi u.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> deflect(Vec3<Real> axis, Real cosine, Real u) {
  return deflect(axis, cosine, sine_cosine_of_turns(u));
}

/// w mirrored at the plane with unit normal m: 2 (w.m) m - w, renormalised so that errors do not
/// grow along a walk.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> mirrored(Vec3<Real> w, Vec3<Real> m) {
  return renormalized(Real(2) * dot(w, m) * m - w);
}

}  // namespace lamella
