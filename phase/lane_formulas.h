#pragma once

// The sampling formulas of phase/sampling.h, phase/vec3.h and the media on lanes of float: the same
// expressions, with select for branches and with approximate reciprocals. Only for sources of
// lamella_lanes(), see phase/lanes.h.

#include "phase/lane_math.h"
#include "phase/sampling.h"

namespace lamella::LAMELLA_ISA {

using FloatVector = Vec3<Floats>;

LAMELLA_INLINE FloatVector select(FloatMask condition, FloatVector a, FloatVector b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z)};
}

LAMELLA_INLINE FloatVector normalized(FloatVector a) { return reciprocal_sqrt(dot(a, a)) * a; }

/// phase/vec3.h: frame_around.
LAMELLA_INLINE Frame<Floats> frame_around(FloatVector n) {
  const Floats sign = copysign(Floats(1), n.z);
  const Floats a = -reciprocal(sign + n.z);
  const Floats b = n.x * n.y * a;
  return {{multiply_add(sign * n.x * n.x, a, Floats(1)), sign * b, -sign * n.x},
          {b, multiply_add(n.y * n.y, a, sign), -n.y},
          n};
}

/// phase/sampling.h: cosine_hemisphere.
LAMELLA_INLINE FloatVector cosine_hemisphere(FloatVector n, Floats u1, Floats u2) {
  const FloatVector v = n + uniform_sphere(u1, u2);
  const Floats l2 = dot(v, v);
  return select(l2 > Floats(0), reciprocal_sqrt(l2) * v, n);
}

/// phase/sampling.h: deflect.
LAMELLA_INLINE FloatVector deflect(FloatVector axis, Floats cosine, Floats u) {
  const Floats s = sqrt(nonnegative((Floats(1) - cosine) * (Floats(1) + cosine)));
  const auto [sin_phi, cos_phi] = sine_cosine_of_turns(u);
  return renormalized(frame_around(axis).to_world({s * cos_phi, s * sin_phi, cosine}));
}

/// phase/sampling.h: mirrored.
LAMELLA_INLINE FloatVector mirrored(FloatVector w, FloatVector m) {
  return renormalized(Floats(2) * dot(w, m) * m - w);
}

/// phase/sggx.h: SggxMatrix, A of S = A A^T.
struct LaneMatrix {
  Floats a00, a10, a11, a20, a21, a22;

  LAMELLA_INLINE explicit LaneMatrix(const float* a)
      : a00(a[0]), a10(a[1]), a11(a[2]), a20(a[3]), a21(a[4]), a22(a[5]) {}
  LAMELLA_INLINE FloatVector apply(FloatVector u) const {
    return {a00 * u.x, multiply_add(a10, u.x, a11 * u.y),
            multiply_add(a20, u.x, multiply_add(a21, u.y, a22 * u.z))};
  }
  LAMELLA_INLINE FloatVector apply_transposed(FloatVector w) const {
    return {multiply_add(a00, w.x, multiply_add(a10, w.y, a20 * w.z)),
            multiply_add(a11, w.y, a21 * w.z), a22 * w.z};
  }
};

/// phase/sggx.h: visible_normal.
LAMELLA_INLINE FloatVector visible_normal(const LaneMatrix& a, FloatVector w, Floats u1,
                                          Floats u2) {
  const FloatVector v = a.apply_transposed(w);
  const FloatVector u = v + sqrt(dot(v, v)) * uniform_sphere(u1, u2);
  return normalized(a.apply(select(dot(u, u) > Floats(0), u, v)));
}

/// phase/henyey_greenstein.h.
LAMELLA_INLINE Floats henyey_greenstein_phase(Floats g, Floats cosine) {
  const Floats a = abs(g), c = select(g < Floats(0), -cosine, cosine);
  const Floats base = multiply_add(Floats(2) * a, Floats(1) - c, (Floats(1) - a) * (Floats(1) - a));
  return divide((Floats(1) - g) * (Floats(1) + g), Floats(4 * kPi) * base * sqrt(base));
}
LAMELLA_INLINE Floats henyey_greenstein_cosine(Floats g, Floats u) {
  const Floats x = multiply_add(Floats(2), u, Floats(-1));
  const Floats d = multiply_add(g, x, Floats(1));
  return divide(multiply_add(x, Floats(1) + g * g,
                             g * Floats(0.5f) * (x * x + Floats(3) + g * g * (x * x - Floats(1)))),
                d * d);
}

/// phase/lambert_sphere.h.
LAMELLA_INLINE Floats lambert_sphere_cosine(Floats u1, Floats u2, Floats u3) {
  const auto [s, c] = sine_cosine_near_zero((u3 - Floats(0.5f)) * Floats(kPi / 2));
  return sqrt((Floats(1) - u1) * (Floats(1) - u2)) * (Floats(2) * s * c) - sqrt(u1 * u2);
}

}  // namespace lamella::LAMELLA_ISA
