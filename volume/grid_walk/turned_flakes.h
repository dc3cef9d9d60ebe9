#pragma once

#include "phase/medium/sggx_formulas.h"

namespace lamella {

/// SGGX flakes about an axis t by a symmetric root of S: A = 1 + (along / across - 1) t t^T, in
/// units of sigma across the axis. Lengths do not matter to normals. Real: lanes of float, or the
/// double that they are held against.
template <class Real>
struct AxialSggxMatrix {
  Vec3<Real> v;
  Real factor;  ///< A = 1 + factor v v^T

  [[nodiscard]] LAMELLA_INLINE Vec3<Real> apply(Vec3<Real> u) const {
    return u + (factor * dot(v, u)) * v;
  }
  [[nodiscard]] LAMELLA_INLINE Vec3<Real> apply_transposed(Vec3<Real> w) const { return apply(w); }
};

/// A of the flakes whose (rho sigma(w))^2 is across2 + sign (v . w)^2: a voxel's record in
/// GridRayTable. With b = rho across and c = rho along, c^2 = b^2 + sign v^2 and
/// c / b - 1 = sign v^2 / (b (b + c)).
template <class Real>
[[nodiscard]] LAMELLA_INLINE AxialSggxMatrix<Real> turned_flakes(Real across2, Vec3<Real> v,
                                                                 Real sign) {
  using std::sqrt;
  const Real across = sqrt(across2);
  const Real along = sqrt(nonnegative(multiply_add(sign, dot(v, v), across2)));
  return {v, sign / (across * (across + along))};
}

/// Fibers whose sigma along the axis is less than this share of that across it leave float too few
/// digits of c.
inline constexpr double kThinnestTurnedFiber = 0.05;

}  // namespace lamella
