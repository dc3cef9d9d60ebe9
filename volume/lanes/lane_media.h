#pragma once

// The media as walks on lanes meet them: which words of an event are spent on what. The formulas
// are those of phase, for lanes of float and for double alike. A medium here has
//   kDiffuse: whether a flake reflects by Lambert's law, its normal drawn by `collide`;
//   kMirror: whether Schlick's factor may apply to it;
//   kWords: words that an event takes, the free flight's first one among them;
//   inverse_area(w): 1 / sigma(w);
//   collide(wi, words): the event; media of null collisions (lane_null_flakes.h) have kNull, and
//     their events `accepted`;
//   sample(event, words): the next w_i, which is -w_o, and the cosine with the mirror's normal;
//   density(event, w_o): p, or its estimate given the event.

#include "phase/medium/henyey_greenstein_formulas.h"
#include "phase/medium/lambert_sphere_formulas.h"
#include "phase/medium/rayleigh_formulas.h"
#include "phase/medium/sggx_formulas.h"
#include "phase/random/block_random.h"
#include "volume/lanes/lane_layers.h"
#include "volume/lanes/lane_vmf.h"

namespace lamella {

template <class Real>
struct LaneEvent {
  Vec3<Real> wi, normal;
  Real inverse_sigma;
};

/// Every lane.
template <class Real>
[[nodiscard]] LAMELLA_INLINE MaskOf<Real> every_lane() {
  return Real(0) <= Real(0);
}

template <class Real>
struct LaneScatter {
  Vec3<Real> next;  ///< w_i of the next event
  Real cosine;      ///< of w_o with the normal of a mirror
};

/// Whether a medium may refuse to collide: flight is by a majorant of sigma, and a lane that is
/// refused only takes the next step.
template <class M>
inline constexpr bool kRefuses = requires {
  requires M::kNull;
};

/// Words that an event of any medium takes, and the place of the roulette's behind them.
inline constexpr int kMediumWords = 7, kRouletteWord = kMediumWords, kEventWords = 8;

template <class Real>
[[nodiscard]] LAMELLA_INLINE Vec3<Real> sphere_point_of(const WordsOf<Real>* words) {
  return sphere_point<Real>(signed_uniform_of(words[0]), azimuth_of(words[1]));
}

/// -w_o where a flake reflects by Lambert's law: w_o along n and a uniform point of the sphere.
/// Where these cancel so does the result: a walk that stands still until its next event.
template <class Real>
[[nodiscard]] LAMELLA_INLINE Vec3<Real> next_by_lambert(Vec3<Real> n, const WordsOf<Real>* words) {
  const Vec3<Real> v = n + sphere_point_of<Real>(words);
  return -reciprocal_sqrt(max(dot(v, v), Real(1e-30))) * v;
}

/// The mirror of an event about its normal.
template <class Real>
[[nodiscard]] LAMELLA_INLINE LaneScatter<Real> mirrored(const LaneEvent<Real>& e) {
  const Real along = dot(e.wi, e.normal);
  return {renormalized(e.wi - (Real(2) * along) * e.normal), along};
}

/// The cosine of two directions with the normal that mirrors one into the other.
template <class Real>
[[nodiscard]] LAMELLA_INLINE Real half_cosine(Vec3<Real> wi, Vec3<Real> wo) {
  using std::sqrt;
  return sqrt(nonnegative(multiply_add(dot(wi, wo), Real(0.5), Real(0.5))));
}

template <class Real>
struct ParticleOnLanes {
  static constexpr bool kDiffuse = false, kMirror = false;
  LAMELLA_INLINE Real inverse_area(Vec3<Real>) const { return Real(1); }
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordsOf<Real>*) const {
    return {wi, wi, Real(1)};
  }
};

template <class Real>
struct LambertSphereOnLanes : ParticleOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::lambert_sphere;
  static constexpr int kWords = 3;
  template <class Reader>
  LAMELLA_INLINE explicit LambertSphereOnLanes(const Reader&) {}
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    const auto polar = lambert_sphere_deflection<Real>(fine_uniform_of(words[1]));
    return {deflect(e.wi, polar, azimuth_of(words[2])), Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_sphere_phase(-dot(e.wi, wo));
  }
};

template <class Real>
struct HenyeyGreensteinOnLanes : ParticleOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::henyey_greenstein;
  static constexpr int kWords = 3;
  Real g;
  template <class Reader>
  LAMELLA_INLINE explicit HenyeyGreensteinOnLanes(const Reader& n) : g(n(kG)) {}
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    const Real cosine = henyey_greenstein_cosine_signed<Real>(g, signed_uniform_of(words[1]));
    return {deflect(e.wi, cosine, azimuth_of(words[2])), Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return henyey_greenstein_phase(g, -dot(e.wi, wo));
  }
};

template <class Real>
struct RayleighOnLanes : ParticleOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::rayleigh;
  static constexpr int kWords = 3;
  template <class Reader>
  LAMELLA_INLINE explicit RayleighOnLanes(const Reader&) {}
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    const Real cosine = rayleigh_cosine_signed<Real>(signed_uniform_of(words[1]));
    return {deflect(e.wi, cosine, azimuth_of(words[2])), Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return rayleigh_phase(-dot(e.wi, wo));
  }
};

template <class Real, class Reader>
[[nodiscard]] LAMELLA_INLINE SggxMatrix<Real> matrix_of(const Reader& n, int field,
                                                        const SggxMatrix<Real>*) {
  return {n(field), n(field + 1), n(field + 2), n(field + 3), n(field + 4), n(field + 5)};
}
template <class Real, class Reader>
[[nodiscard]] LAMELLA_INLINE UprightSggxMatrix<Real> matrix_of(const Reader& n, int field,
                                                               const UprightSggxMatrix<Real>*) {
  return {n(field), n(field + 5)};
}

/// Matrix: SggxMatrix, or UprightSggxMatrix where that is all there is to it.
template <class Real, template <class> class Matrix>
struct SggxOnLanes {
  Matrix<Real> a;
  template <class Reader>
  LAMELLA_INLINE explicit SggxOnLanes(const Reader& n)
      : a(matrix_of<Real>(n, kA, static_cast<const Matrix<Real>*>(nullptr))) {}
  LAMELLA_INLINE Real inverse_area(Vec3<Real> w) const {
    const Vec3<Real> v = a.apply_transposed(w);
    return reciprocal_sqrt(dot(v, v));
  }
  [[nodiscard]] LAMELLA_INLINE Vec3<Real> along_normal(Vec3<Real> wi,
                                                       const WordsOf<Real>* words) const {
    return along_visible_normal(a, wi, sphere_point_of<Real>(words));
  }
};

template <class Real, template <class> class Matrix>
struct SggxMirrors : SggxOnLanes<Real, Matrix> {
  static constexpr auto kKind = LaneMediumKind::sggx_mirror;
  static constexpr bool kDiffuse = false, kMirror = true;
  static constexpr int kWords = 3;
  Matrix<Real> inverse;
  Real density_scale;
  template <class Reader>
  LAMELLA_INLINE explicit SggxMirrors(const Reader& n)
      : SggxOnLanes<Real, Matrix>(n),
        inverse(matrix_of<Real>(n, kInverse, static_cast<const Matrix<Real>*>(nullptr))),
        density_scale(n(kDensityScale)) {}
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordsOf<Real>*) const {
    return {wi, wi, this->inverse_area(wi)};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    const Vec3<Real> m = this->along_normal(e.wi, words + 1);
    const Real along = dot(e.wi, m), m2 = max(dot(m, m), Real(1e-30));
    // w_i - 2 (w_i.m) m / m^2 is what w_o points away from
    return {renormalized(e.wi - (Real(2) * along * reciprocal(m2)) * m),
            along * reciprocal_sqrt(m2)};
  }
  /// D(h) / (4 sigma(w_i))
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    const Vec3<Real> h = e.wi + wo, u = inverse.apply(h);
    return normal_density_of(dot(h, h), dot(u, u)) * density_scale * e.inverse_sigma;
  }
};

/// A flake that reflects by Lambert's law, its normal drawn.
template <class Real>
[[nodiscard]] LAMELLA_INLINE Real lambert_flake_density(const LaneEvent<Real>& e, Vec3<Real> wo) {
  return nonnegative(dot(e.normal, wo)) * Real(1 / kPi);
}

template <class Real, template <class> class Matrix>
struct SggxLambertians : SggxOnLanes<Real, Matrix> {
  static constexpr auto kKind = LaneMediumKind::sggx_lambert;
  static constexpr bool kDiffuse = true, kMirror = false;
  static constexpr int kWords = 5;
  using SggxOnLanes<Real, Matrix>::SggxOnLanes;
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordsOf<Real>* words) const {
    const Vec3<Real> m = this->along_normal(wi, words + 1);
    return {wi, reciprocal_sqrt(max(dot(m, m), Real(1e-30))) * m, Real(1)};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    return {next_by_lambert(e.normal, words + 3), Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_flake_density(e, wo);
  }
};

template <class Real>
using SggxMirrorOnLanes = SggxMirrors<Real, SggxMatrix>;
template <class Real>
using SggxLambertOnLanes = SggxLambertians<Real, SggxMatrix>;
template <class Real>
using UprightSggxMirrorOnLanes = SggxMirrors<Real, UprightSggxMatrix>;
template <class Real>
using UprightSggxLambertOnLanes = SggxLambertians<Real, UprightSggxMatrix>;

/// Flakes: VmfOnLanes, or NarrowVmfOnLanes.
template <class Real, template <class> class Flakes>
struct VmfLambertians : Flakes<Real> {
  static constexpr auto kKind = LaneMediumKind::vmf_lambert;
  static constexpr bool kDiffuse = true, kMirror = false;
  static constexpr int kWords = 5;
  using Flakes<Real>::Flakes;
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordsOf<Real>* words) const {
    const Real u = dot(wi, this->axis);
    return {wi, this->normal(wi, u, this->row_from_behind(u), words + 1), Real(1)};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    return {next_by_lambert(e.normal, words + 3), Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_flake_density(e, wo);
  }
};

template <class Real, template <class> class Flakes>
struct VmfMirrors : Flakes<Real> {
  static constexpr auto kKind = LaneMediumKind::vmf_mirror;
  static constexpr bool kDiffuse = false, kMirror = true;
  static constexpr int kWords = 3;
  Real density_scale;
  template <class Reader>
  LAMELLA_INLINE explicit VmfMirrors(const Reader& n)
      : Flakes<Real>(n), density_scale(n(kDensityScale)) {}
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordsOf<Real>* words) const {
    const Real u = dot(wi, this->axis);
    const Real row = this->row_from_behind(u);
    return {wi, this->normal(wi, u, row, words + 1),
            reciprocal(max(this->sigma_of(u, row), Real(1e-6)))};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e, const WordsOf<Real>*) const {
    return mirrored(e);
  }
  /// D(h) / (4 sigma(w_i))
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    using std::abs, std::exp, std::sqrt;
    const Vec3<Real> h = e.wi + wo;
    // 1 - cosine without cancellation: sine^2 / (1 + cosine) in front.
    const Real along = dot(h, this->axis);
    const Vec3<Real> flat = h - along * this->axis;
    const Real flat2 = dot(flat, flat);
    const Real inverse2 = reciprocal(max(multiply_add(along, along, flat2), Real(1e-20)));
    const Real cosine = min(along * sqrt(inverse2), Real(1));
    const Real below = select(along > Real(0), flat2 * inverse2 * reciprocal(Real(1) + abs(cosine)),
                              Real(1) - cosine);
    return exp(-(this->kappa * below)) * density_scale * e.inverse_sigma;
  }
};

template <class Real>
using VmfMirrorOnLanes = VmfMirrors<Real, VmfOnLanes>;
template <class Real>
using VmfLambertOnLanes = VmfLambertians<Real, VmfOnLanes>;
template <class Real>
using NarrowVmfMirrorOnLanes = VmfMirrors<Real, NarrowVmfOnLanes>;
template <class Real>
using NarrowVmfLambertOnLanes = VmfLambertians<Real, NarrowVmfOnLanes>;

/// Lambert's law below all layers: w_i does not matter.
template <class Real>
struct SubstrateOnLanes {
  static constexpr auto kKind = LaneMediumKind::substrate;
  static constexpr bool kDiffuse = true, kMirror = false;
  static constexpr int kWords = 3;
  template <class Reader>
  LAMELLA_INLINE explicit SubstrateOnLanes(const Reader&) {}
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordsOf<Real>*) const {
    return {wi, {Real(0), Real(0), Real(1)}, Real(1)};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    // Upwards where float lets the two cancel, too: what it meets next may be an interface.
    const Vec3<Real> p = sphere_point_of<Real>(words + 1);
    const Vec3<Real> v{p.x, p.y, max(e.normal.z + p.z, Real(1e-12))};
    return {-reciprocal_sqrt(dot(v, v)) * v, Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_flake_density(e, wo);
  }
};

}  // namespace lamella
