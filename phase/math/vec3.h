#pragma once

#include <cmath>

#include "phase/math/real.h"

namespace lamella {

/// Three numbers; Real is double (the reference) or a pack of float lanes. Directions are unit
/// vectors that point away from the stack, z up (the macroscopic normal).
template <class Real>
struct Vec3 {
  Real x, y, z;

  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3 operator*(Real s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

using Direction = Vec3<double>;

template <class Real>
[[nodiscard]] constexpr Real dot(Vec3<Real> a, Vec3<Real> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class Real>
[[nodiscard]] constexpr Vec3<Real> cross(Vec3<Real> a, Vec3<Real> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class Real>
[[nodiscard]] Real length(Vec3<Real> a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}

/// The unit vector along a. a must not be zero.
template <class Real>
[[nodiscard]] Vec3<Real> normalized(Vec3<Real> a) {
  return reciprocal_sqrt(dot(a, a)) * a;
}

/// a where the condition holds, else b.
template <class Mask, class Real>
[[nodiscard, gnu::always_inline]] inline Vec3<Real> select(Mask condition, Vec3<Real> a,
                                                           Vec3<Real> b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z)};
}

/// A vector whose length is 1 up to rounding, made unit again by one step of Newton's: an error e
/// of the length becomes 3/2 e^2, without root or division.
template <class Real>
[[nodiscard]] constexpr Vec3<Real> renormalized(Vec3<Real> a) {
  return (Real(1.5) - Real(0.5) * dot(a, a)) * a;
}

/// An orthonormal right-handed frame (s, t, n).
template <class Real>
struct Frame {
  Vec3<Real> s, t, n;

  [[nodiscard]] constexpr Vec3<Real> to_world(Vec3<Real> v) const {
    return v.x * s + v.y * t + v.z * n;
  }
  [[nodiscard]] constexpr Vec3<Real> to_local(Vec3<Real> v) const {
    return {dot(v, s), dot(v, t), dot(v, n)};
  }
};

/// A frame around the unit vector n without branches (Duff et al. 2017, "Building an orthonormal
/// basis, revisited", JCGT 6(1)). n = +z gives the identity.
template <class Real>
[[nodiscard, gnu::always_inline]] inline Frame<Real> frame_around(Vec3<Real> n) {
  using std::copysign;
  const Real sign = copysign(Real(1), n.z);
  const Real a = -reciprocal(sign + n.z);
  const Real b = n.x * n.y * a;
  return {{multiply_add(sign * n.x * n.x, a, Real(1)), sign * b, -sign * n.x},
          {b, multiply_add(n.y * n.y, a, sign), -n.y},
          n};
}

}  // namespace lamella
