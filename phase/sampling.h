#pragma once

#include "phase/direction.h"

namespace lamella {

/// Uniform point of the unit sphere from two uniforms in (0, 1).
template <class Real>
[[nodiscard]] Vec3<Real> uniform_sphere(Real u1, Real u2) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Real z = Real(1) - Real(2) * u1;
  const Real r = Real(2) * sqrt(u1 * (Real(1) - u1));
  const Real phi = Real(2 * kPi) * u2;
  return {r * cos(phi), r * sin(phi), z};
}

/// Direction about the unit vector n with density cos / pi: the normalised sum of n and a uniform
/// point of the sphere (Lambert's law needs no frame). At the antipode itself, n.
template <class Real>
[[nodiscard]] Vec3<Real> cosine_hemisphere(Vec3<Real> n, Real u1, Real u2) {
  using std::sqrt;
  const Vec3<Real> v = n + uniform_sphere(u1, u2);
  const Real l2 = dot(v, v);
  if (!(l2 > Real(0))) return n;
  return (Real(1) / sqrt(l2)) * v;
}

/// The direction that makes the given cosine with the unit vector axis, at azimuth 2 pi u.
template <class Real>
[[nodiscard]] Vec3<Real> deflect(Vec3<Real> axis, Real cosine, Real u) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Real s2 = (Real(1) - cosine) * (Real(1) + cosine);
  const Real s = sqrt(s2 > Real(0) ? s2 : Real(0));
  const Real phi = Real(2 * kPi) * u;
  const Frame<Real> frame = frame_around(axis);
  return normalized(frame.to_world({s * cos(phi), s * sin(phi), cosine}));
}

/// w mirrored at the plane with unit normal m: 2 (w.m) m - w, renormalised so that errors do not
/// grow along a walk.
template <class Real>
[[nodiscard]] Vec3<Real> mirrored(Vec3<Real> w, Vec3<Real> m) {
  return normalized(Real(2) * dot(w, m) * m - w);
}

}  // namespace lamella
