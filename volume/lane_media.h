#pragma once

// The media as walks on lanes meet them: which words of an event are spent on what. The formulas
// are those of phase, for lanes of float and for double alike. A medium here has
//   kNull: whether `collide` may refuse (a null collision, flight being by a majorant of sigma);
//   kDiffuse: whether a flake reflects by Lambert's law, its normal drawn by `collide`;
//   kMirror: whether Schlick's factor may apply to it;
//   inverse_area(w): 1 / sigma(w), or of its majorant;
//   collide(wi, words): the event, with `accepted` where kNull;
//   sample(event, words): w_o, and the cosine with the mirror's normal;
//   density(event, w_o): p, or its estimate given the event.
// words[0].w[0] is left for the free flight, words[1].w[3] for the roulette.

#include "phase/block_random.h"
#include "phase/henyey_greenstein_formulas.h"
#include "phase/lambert_sphere_formulas.h"
#include "phase/sggx_formulas.h"
#include "phase/vmf_mixture.h"
#include "volume/layer_numbers.h"

namespace lamella {

template <class Real>
struct LaneEvent {
  Vec3<Real> wi, normal;
  Real inverse_sigma;
  MaskOf<Real> accepted;
};

/// Every lane.
template <class Real>
[[nodiscard]] LAMELLA_INLINE MaskOf<Real> every_lane() {
  return Real(0) <= Real(0);
}

template <class Real>
struct LaneScatter {
  Vec3<Real> wo;
  Real cosine;  ///< of w_o with the normal of a mirror
};

/// The cosine of two directions with the normal that mirrors one into the other.
template <class Real>
[[nodiscard]] LAMELLA_INLINE Real half_cosine(Vec3<Real> wi, Vec3<Real> wo) {
  using std::sqrt;
  return sqrt(nonnegative(multiply_add(dot(wi, wo), Real(0.5), Real(0.5))));
}

template <class Real>
struct ParticleOnLanes {
  static constexpr bool kNull = false, kDiffuse = false, kMirror = false;
  using Block = WordBlock<WordsOf<Real>>;
  LAMELLA_INLINE Real inverse_area(Vec3<Real>) const { return Real(1); }
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const Block*) const {
    return {wi, wi, Real(1), every_lane<Real>()};
  }
};

template <class Real>
struct LambertSphereOnLanes : ParticleOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::lambert_sphere;
  template <class Reader>
  LAMELLA_INLINE explicit LambertSphereOnLanes(const Reader&) {}
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordBlock<WordsOf<Real>>* words) const {
    const auto* w = words[0].w;
    const Real cosine = lambert_sphere_cosine(uniform_of(w[1]), uniform_of(w[2]), uniform_of(w[3]));
    return {deflect(-e.wi, cosine, uniform_of_rest(w[1], w[2], w[3])), Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_sphere_phase(-dot(e.wi, wo));
  }
};

template <class Real>
struct HenyeyGreensteinOnLanes : ParticleOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::henyey_greenstein;
  Real g;
  template <class Reader>
  LAMELLA_INLINE explicit HenyeyGreensteinOnLanes(const Reader& n) : g(n(kG)) {}
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordBlock<WordsOf<Real>>* words) const {
    const auto* w = words[0].w;
    return {deflect(-e.wi, henyey_greenstein_cosine(g, uniform_of(w[1])), uniform_of(w[2])),
            Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return henyey_greenstein_phase(g, -dot(e.wi, wo));
  }
};

template <class Real>
struct SggxOnLanes {
  static constexpr bool kNull = false;
  SggxMatrix<Real> a;
  template <class Reader>
  LAMELLA_INLINE explicit SggxOnLanes(const Reader& n)
      : a{n(kA), n(kA + 1), n(kA + 2), n(kA + 3), n(kA + 4), n(kA + 5)} {}
  LAMELLA_INLINE Real inverse_area(Vec3<Real> w) const {
    const Vec3<Real> v = a.apply_transposed(w);
    return reciprocal_sqrt(dot(v, v));
  }
};

template <class Real>
struct SggxMirrorOnLanes : SggxOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::sggx_mirror;
  static constexpr bool kDiffuse = false, kMirror = true;
  SggxMatrix<Real> inverse;
  Real density_scale;
  template <class Reader>
  LAMELLA_INLINE explicit SggxMirrorOnLanes(const Reader& n)
      : SggxOnLanes<Real>(n),
        inverse{n(kInverse),     n(kInverse + 1), n(kInverse + 2),
                n(kInverse + 3), n(kInverse + 4), n(kInverse + 5)},
        density_scale(n(kDensityScale)) {}
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordBlock<WordsOf<Real>>*) const {
    return {wi, wi, this->inverse_area(wi), every_lane<Real>()};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordBlock<WordsOf<Real>>* words) const {
    const auto* w = words[0].w;
    const Vec3<Real> m = visible_normal(this->a, e.wi, uniform_of(w[1]), uniform_of(w[2]));
    return {mirrored(e.wi, m), dot(e.wi, m)};
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

template <class Real>
struct SggxLambertOnLanes : SggxOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::sggx_lambert;
  static constexpr bool kDiffuse = true, kMirror = false;
  using SggxOnLanes<Real>::SggxOnLanes;
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi,
                                         const WordBlock<WordsOf<Real>>* words) const {
    const auto* w = words[0].w;
    return {wi, visible_normal(this->a, wi, uniform_of(w[1]), uniform_of(w[2])), Real(1),
            every_lane<Real>()};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordBlock<WordsOf<Real>>* words) const {
    const auto* w = words[0].w;
    return {cosine_hemisphere(e.normal, uniform_of(w[3]), uniform_of_rest(w[1], w[2], w[3])),
            Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_flake_density(e, wo);
  }
};

/// vMF flakes: flight by the mixture's majorant, normals from the mixture by tabulated marginals;
/// the acceptance is sigma over that majorant, at least 0.7 from the front.
template <class Real>
struct VmfOnLanes {
  static constexpr bool kNull = true;
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  Vec3<Real> axis, tangent_at_pole;
  VisibleNormalMixture<Real> mixture;
  Words first_piece;
  const float* tables;
  template <class Reader>
  LAMELLA_INLINE explicit VmfOnLanes(const Reader& n)
      : axis{n(kAxis), n(kAxis + 1), n(kAxis + 2)},
        tangent_at_pole(frame_around(axis).s),
        mixture{n(kFront), n(kBack), n(kSide)},
        first_piece(word_of(n(kTable))),
        tables(n.numbers.tables) {}

  LAMELLA_INLINE Real inverse_area(Vec3<Real> w) const {
    using std::sqrt;
    const Real u = dot(w, axis);
    const Vec3<Real> across = w - u * axis;
    // Nothing faces the light that comes straight from behind narrow flakes.
    return reciprocal(max(mixture.majorant(u, sqrt(dot(across, across))), Real(1e-30)));
  }
  /// The cubic of a table, x in [0, kMarginalPieces).
  LAMELLA_INLINE Real tabulated(Words table, Real x) const {
    const Words piece = word_of(x);
    const Real t = x - number_of(piece);
    const Words at = shift_left<2>(first_piece + table + piece);
    Real value = multiply_add(t, gather(tables + 3, at), gather(tables + 2, at));
    value = multiply_add(t, value, gather(tables + 1, at));
    return multiply_add(t, value, gather(tables, at));
  }
  /// sigma(w), absolute error below 2e-7.
  LAMELLA_INLINE Real sigma(Vec3<Real> w) const {
    const Real x = multiply_add(dot(w, axis), Real(kMarginalPieces / 2), Real(kMarginalPieces / 2));
    return nonnegative(
        tabulated(Words(4u * kMarginalPieces), min(nonnegative(x), Real(kMarginalPieces - 1e-3))));
  }
  LAMELLA_INLINE LaneEvent<Real> draw(Vec3<Real> wi, const WordBlock<Words>* words) const {
    using std::exp, std::log, std::sqrt;
    const Real u = dot(wi, axis);
    const Vec3<Real> across = wi - u * axis;
    const Real s2 = dot(across, across), inverse_s = reciprocal_sqrt(max(s2, Real(1e-10)));
    const Real s = s2 * inverse_s;
    const Vec3<Real> tangent = select(s2 < Real(1e-10), tangent_at_pole, inverse_s * across);
    const Mask behind = u < Real(0);
    const Mask is_axial = uniform_of(words[0].w[1]) * mixture.majorant(u, s) < mixture.axial(u);
    // 1 - the cosine with the axis, by cubics in t: t^2 or t^3 of the (folded) uniform number.
    const Real xi = uniform_of(words[0].w[2]);
    const Real folded = Real(2) * min(xi, Real(1) - xi);
    const Real t = select(is_axial, sqrt(xi), exp(log(folded) * Real(1.0 / 3)));
    const auto table = [](unsigned n) { return Words(n * kMarginalPieces); };
    const auto word_mask = [](Mask m) { return to_word_mask(m); };
    const Words which = select(word_mask(is_axial), select(word_mask(behind), table(1), table(0)),
                               select(word_mask(xi > Real(0.5)), table(3), table(2)));
    const Real below =
        tabulated(which, min(t * Real(kMarginalPieces), Real(kMarginalPieces - 1e-3)));
    const Vec3<Real> m = proposed_normal(is_axial, below, uniform_of(words[0].w[3]));
    return {wi, renormalized(m.x * tangent + m.y * cross(axis, tangent) + m.z * axis), Real(1),
            takes_visible_normal(u, s, m, uniform_of(words[1].w[0]))};
  }
};

template <class Real>
struct VmfLambertOnLanes : VmfOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::vmf_lambert;
  static constexpr bool kDiffuse = true, kMirror = false;
  using VmfOnLanes<Real>::VmfOnLanes;
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi,
                                         const WordBlock<WordsOf<Real>>* words) const {
    return this->draw(wi, words);
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordBlock<WordsOf<Real>>* words) const {
    return {cosine_hemisphere(e.normal, uniform_of(words[1].w[1]), uniform_of(words[1].w[2])),
            Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_flake_density(e, wo);
  }
};

template <class Real>
struct VmfMirrorOnLanes : VmfOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::vmf_mirror;
  static constexpr bool kDiffuse = false, kMirror = true;
  Real kappa, density_scale;
  template <class Reader>
  LAMELLA_INLINE explicit VmfMirrorOnLanes(const Reader& n)
      : VmfOnLanes<Real>(n), kappa(n(kKappa)), density_scale(n(kDensityScale)) {}
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi,
                                         const WordBlock<WordsOf<Real>>* words) const {
    LaneEvent<Real> e = this->draw(wi, words);
    e.inverse_sigma = reciprocal(max(this->sigma(wi), Real(1e-6)));
    return e;
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordBlock<WordsOf<Real>>*) const {
    return {mirrored(e.wi, e.normal), dot(e.wi, e.normal)};
  }
  /// D(h) / (4 sigma(w_i))
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    using std::exp;
    const Vec3<Real> h = e.wi + wo;
    const Real cosine = dot(h, this->axis) * reciprocal_sqrt(max(dot(h, h), Real(1e-20)));
    return exp(kappa * (min(cosine, Real(1)) - Real(1))) * density_scale * e.inverse_sigma;
  }
};

/// Lambert's law below all layers: w_i does not matter.
template <class Real>
struct SubstrateOnLanes {
  static constexpr auto kKind = LaneMediumKind::substrate;
  static constexpr bool kNull = false, kDiffuse = true, kMirror = false;
  template <class Reader>
  LAMELLA_INLINE explicit SubstrateOnLanes(const Reader&) {}
  LAMELLA_INLINE LaneEvent<Real> collide(Vec3<Real> wi, const WordBlock<WordsOf<Real>>*) const {
    return {wi, {Real(0), Real(0), Real(1)}, Real(1), every_lane<Real>()};
  }
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordBlock<WordsOf<Real>>* words) const {
    const auto* w = words[0].w;
    return {cosine_hemisphere(e.normal, uniform_of(w[1]), uniform_of(w[2])), Real(1)};
  }
  LAMELLA_INLINE Real density(const LaneEvent<Real>& e, Vec3<Real> wo) const {
    return lambert_flake_density(e, wo);
  }
};

}  // namespace lamella
