#pragma once

#include "phase/math/sampling.h"

namespace lamella {

/// Visible normals of flakes whose distribution D is symmetric about `axis`, as two proposals: the
/// projected cosine m.w = u z + s x (x along the tangent, z along the axis) is at most
/// |u| <sign(u) z> + s <x>, and D(m) times each of these can be sampled. A proposal is accepted
/// with the probability of the projected cosine over that bound. front, back, side: sigma(1),
/// sigma(-1), sigma(0), the integrals of the proposals.
template <class Real>
struct VisibleNormalMixture {
  Real front, back, side;

  /// The integral of the bound, a majorant of sigma at u = w.axis, s = sqrt(1 - u^2).
  [[nodiscard]] LAMELLA_INLINE Real majorant(Real u, Real s) const {
    return multiply_add(s, side, axial(u));
  }
  /// The axial proposal's part of the majorant.
  [[nodiscard]] LAMELLA_INLINE Real axial(Real u) const {
    using std::abs;
    return abs(u) * select(u < Real(0), back, front);
  }
};

/// Whether the normal m, in the frame (tangent, binormal, axis), is accepted, by a uniform number.
template <class Real>
[[nodiscard]] LAMELLA_INLINE auto takes_visible_normal(Real u, Real s, Vec3<Real> m, Real uniform) {
  using std::abs;
  const Real projected = multiply_add(u, m.z, s * m.x);
  const Real facing = select(u < Real(0), -m.z, m.z);
  const Real bound = multiply_add(abs(u), nonnegative(facing), s * nonnegative(m.x));
  return uniform * bound < projected;
}

/// A proposal's normal in the frame (tangent, binormal, axis) from 1 - z and a uniform number in
/// [-1, 1]: the axial one turns it all around, the tangential one by the cosine law towards the
/// tangent.
template <class Real, class Mask>
[[nodiscard]] LAMELLA_INLINE Vec3<Real> proposed_normal(Mask is_axial, Real below, Real uniform) {
  using std::sqrt;
  const Real r = sqrt(nonnegative(below * (Real(2) - below)));
  const auto [sine, cosine] = sine_cosine_of_half_turns(uniform);
  const Real across = sqrt(nonnegative(Real(1) - uniform * uniform));
  return {r * select(is_axial, cosine, across), r * select(is_axial, sine, uniform),
          Real(1) - below};
}

}  // namespace lamella
