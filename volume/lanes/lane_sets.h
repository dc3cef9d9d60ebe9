#pragma once

// The layers that walks on lanes go through, by how much of them is known in advance: which media
// an event may meet, and how a flight crosses layers. A set has
//   kSingle: all lanes are in the same layer;
//   kCountsSteps: steps are others than events;
//   words(): random words that an event takes;
//   visit(layers, f): f(medium, what lanes have in common, which lanes) for each medium present;
//   numbers(setting, layers): those of each lane's layer.

#include "volume/lanes/lane_state.h"

namespace lamella {

/// What all lanes have in common at an event, as scores see it. kSame: the medium and the layer.
struct LanesDiffer {
  static constexpr bool kSame = false, kAlone = false;
};
/// kAlone: of the only layer.
template <bool kOnly>
struct LanesAgree {
  static constexpr bool kSame = true, kAlone = kOnly;
  int layer = 0;
};

/// One layer of one medium, known at compile time. kSteps: between interfaces, whose meetings are
/// steps, too, as null collisions are.
template <class Real, template <class> class M, bool kSteps = false>
struct OneMedium {
  static constexpr bool kSingle = true, kBounded = false;
  static constexpr bool kNull = kRefuses<M<Real>>, kCountsSteps = kSteps || kNull;
  using Scalar = typename NumberTraits<Real>::Scalar;
  M<Real> medium;
  Real depth;

  LAMELLA_INLINE explicit OneMedium(const WalkSetting<Scalar>& t)
      : medium(OneLayer<Real>{*t.layers, 0}), depth(t.layers->value[kDepth][0]) {}
  LAMELLA_INLINE int words() const { return M<Real>::kWords; }
  template <class F>
  LAMELLA_INLINE void visit(WordsOf<Real>, const F& f) const {
    f(medium, LanesAgree<true>{}, every_lane<Real>());
  }
  LAMELLA_INLINE OneLayer<Real> numbers(const WalkSetting<Scalar>& t, WordsOf<Real>) const {
    return {*t.layers, 0};
  }
  /// Moves y by a flight of `remaining` mean free paths; whether it ends at a collision.
  LAMELLA_INLINE MaskOf<Real> fly(Vec3<Real> wi, Real remaining, MaskOf<Real>, WordsOf<Real>&,
                                  Real& y) const {
    y = multiply_add(remaining * medium.inverse_area(wi), wi.z, y);
    // The limits count, too: a flight of length 0 from them does not leave.
    return is_within(y, depth);
  }
};

/// One of several layers or the substrate, which all lanes are in; its medium is known at compile
/// time.
template <class Real, template <class> class M>
struct OneOfLayers {
  static constexpr bool kSingle = true, kBounded = false, kCountsSteps = false;
  using Scalar = typename NumberTraits<Real>::Scalar;
  using Mask = MaskOf<Real>;
  static constexpr bool kSubstrate = M<Real>::kKind == LaneMediumKind::substrate;
  static constexpr int kWords = M<Real>::kWords;
  M<Real> medium;
  int layer, word_count;

  LAMELLA_INLINE OneOfLayers(const WalkSetting<Scalar>& t, int at)
      : medium(OneLayer<Real>{*t.layers, kSubstrate ? 0 : at}), layer(at), word_count(t.words) {}
  LAMELLA_INLINE int words() const { return word_count; }
  LAMELLA_INLINE OneLayer<Real> numbers(const WalkSetting<Scalar>& t, WordsOf<Real>) const {
    return {*t.layers, layer};
  }
  template <class F>
  LAMELLA_INLINE void visit(WordsOf<Real>, const F& f) const {
    f(medium, LanesAgree<false>{layer}, every_lane<Real>());
  }
};

/// The kind of a layer, or of the substrate below the last one.
template <class Scalar>
[[nodiscard]] LAMELLA_INLINE LaneMediumKind lane_medium_of(const WalkSetting<Scalar>& t,
                                                           int layer) {
  return layer == t.layer_count
             ? LaneMediumKind::substrate
             : static_cast<LaneMediumKind>(static_cast<int>(t.layers->value[kKind][layer]));
}
/// f.template operator()<M>(), M the medium of a layer, or the substrate.
template <class Scalar, class F>
LAMELLA_INLINE void with_lane_medium(const WalkSetting<Scalar>& t, int layer, const F& f) {
  const bool upright = t.upright, narrow = t.layers->value[kFacing][layer % kMostLaneLayers] < 1;
  switch (lane_medium_of(t, layer)) {
    case LaneMediumKind::lambert_sphere:
      return f.template operator()<LambertSphereOnLanes>();
    case LaneMediumKind::henyey_greenstein:
      return f.template operator()<HenyeyGreensteinOnLanes>();
    case LaneMediumKind::rayleigh:
      return f.template operator()<RayleighOnLanes>();
    case LaneMediumKind::sggx_mirror:
      return upright ? f.template operator()<UprightSggxMirrorOnLanes>()
                     : f.template operator()<SggxMirrorOnLanes>();
    case LaneMediumKind::sggx_lambert:
      return upright ? f.template operator()<UprightSggxLambertOnLanes>()
                     : f.template operator()<SggxLambertOnLanes>();
    case LaneMediumKind::vmf_mirror:
      return narrow ? f.template operator()<NarrowVmfMirrorOnLanes>()
                    : f.template operator()<VmfMirrorOnLanes>();
    case LaneMediumKind::vmf_lambert:
      return narrow ? f.template operator()<NarrowVmfLambertOnLanes>()
                    : f.template operator()<VmfLambertOnLanes>();
    case LaneMediumKind::substrate:
      return f.template operator()<SubstrateOnLanes>();
  }
}

/// Up to kMostLaneLayers layers of any media, perhaps over a substrate, whose layer is the count.
template <class Real>
struct AnyMedia {
  static constexpr bool kSingle = false, kCountsSteps = false, kBounded = false;
  using Scalar = typename NumberTraits<Real>::Scalar;
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  const WalkSetting<Scalar>& t;
  Words count;
  bool one_kind, has_vmf, has_sggx;

  LAMELLA_INLINE explicit AnyMedia(const WalkSetting<Scalar>& setting)
      : t(setting),
        count(static_cast<std::uint32_t>(setting.layer_count)),
        one_kind((setting.kinds & (setting.kinds - 1)) == 0),
        has_vmf(has(LaneMediumKind::vmf_mirror) || has(LaneMediumKind::vmf_lambert)),
        has_sggx(has(LaneMediumKind::sggx_mirror) || has(LaneMediumKind::sggx_lambert)) {}
  LAMELLA_INLINE bool has(LaneMediumKind kind) const {
    return (t.kinds >> static_cast<int>(kind) & 1u) != 0;
  }
  LAMELLA_INLINE int words() const { return t.words; }

  template <class M, class F>
  LAMELLA_INLINE void visit_kind(Words layer, Real kind, const F& f) const {
    if (!has(M::kKind)) return;
    const Mask here = equal(kind, Real(static_cast<int>(M::kKind)));
    if (!one_kind && !any(here)) return;
    f(M(LayerPerLane<Real>{*t.layers, layer}), LanesDiffer{}, here);
  }
  LAMELLA_INLINE LayerPerLane<Real> numbers(const WalkSetting<Scalar>&, Words layer) const {
    return {*t.layers, layer};
  }
  /// f(medium, what lanes have in common, that of which lanes) for each medium present.
  template <class F>
  LAMELLA_INLINE void visit(Words layer, const F& f) const {
    Real kind = lookup(t.layers->value[kKind], layer);
    if (t.substrate)
      kind = select(to_float_mask(equal(layer, count)),
                    Real(static_cast<int>(LaneMediumKind::substrate)), kind);
    visit_kind<LambertSphereOnLanes<Real>>(layer, kind, f);
    visit_kind<HenyeyGreensteinOnLanes<Real>>(layer, kind, f);
    visit_kind<RayleighOnLanes<Real>>(layer, kind, f);
    visit_kind<SggxMirrorOnLanes<Real>>(layer, kind, f);
    visit_kind<SggxLambertOnLanes<Real>>(layer, kind, f);
    if (t.narrow) {
      visit_kind<NarrowVmfMirrorOnLanes<Real>>(layer, kind, f);
      visit_kind<NarrowVmfLambertOnLanes<Real>>(layer, kind, f);
    } else {
      visit_kind<VmfMirrorOnLanes<Real>>(layer, kind, f);
      visit_kind<VmfLambertOnLanes<Real>>(layer, kind, f);
    }
    visit_kind<SubstrateOnLanes<Real>>(layer, kind, f);
  }

  LAMELLA_INLINE Real inverse_area(Words layer, Vec3<Real> w) const {
    const LayerPerLane<Real> numbers{*t.layers, layer};
    Real inverse(1);
    if (has_sggx)  // particles have the unit matrix
      inverse = t.upright ? SggxOnLanes<Real, UprightSggxMatrix>(numbers).inverse_area(w)
                          : SggxOnLanes<Real, SggxMatrix>(numbers).inverse_area(w);
    if (!has_vmf) return inverse;
    const Real of_vmf = t.narrow ? NarrowVmfOnLanes<Real>(numbers).inverse_area(w)
                                 : VmfOnLanes<Real>(numbers).inverse_area(w);
    return select(numbers(kWidth) > Real(0), of_vmf, inverse);
  }

  /// A flight of some lanes, on its way.
  struct Flight {
    Mask flies, collides, down;
    Real inverse_mu, remaining;
  };
  /// By `remaining` mean free paths, of the lanes `flies`.
  LAMELLA_INLINE Flight begin_flight(Vec3<Real> wi, Real remaining, Mask flies, Words& layer,
                                     Real& y) const {
    using std::abs;
    if (t.substrate) {  // leaves it upwards
      const Mask from = flies & to_float_mask(equal(layer, count));
      layer = select(to_word_mask(from), layer - Words(1u), layer);
      y = select(from, lookup(t.layers->value[kDepth], layer), y);
    }
    return {flies, without(flies, flies), wi.z > Real(0), reciprocal(max(abs(wi.z), Real(1e-30))),
            remaining};
  }
  /// Stops the lanes that collide in a layer at their place there; whether any lane flies past it.
  /// `inverse`: 1 / sigma(w_i).
  LAMELLA_INLINE static bool flies_past(Flight& f, Real inverse, Real depth, Vec3<Real> wi,
                                        Real& y) {
    const Real to = multiply_add(f.remaining * inverse, wi.z, y);
    const Mask inside = f.flies & ((f.down & (to < depth)) | without(to > Real(0), f.down));
    f.collides = f.collides | inside;
    y = select(inside, to, y);
    f.flies = without(f.flies, inside);
    return any(f.flies);
  }
  /// What is left of the flight beyond a layer.
  LAMELLA_INLINE void spend(Flight& f, Real inverse, Real depth, Real y) const {
    const Real way = select(f.down, depth - y, y);
    // Of a half space that is left downwards nothing remains to be crossed.
    Real spent = min(way * f.inverse_mu, Real(1e30));
    if (has_vmf || has_sggx) spent = spent * reciprocal(inverse);
    f.remaining = nonnegative(f.remaining - spent);
  }
  /// Through one layer, or to a collision in it; whether any lane flies on.
  LAMELLA_INLINE bool cross(Flight& f, Vec3<Real> wi, Words& layer, Real& y) const {
    const Real inverse = inverse_area(layer, wi), depth = lookup(t.layers->value[kDepth], layer);
    if (!flies_past(f, inverse, depth, wi, y)) return false;
    spend(f, inverse, depth, y);
    const auto up_words = to_word_mask(without(f.flies, f.down)),
               down_words = to_word_mask(f.flies & f.down);
    layer = select(up_words, layer - Words(1u), select(down_words, layer + Words(1u), layer));
    if (t.substrate) f.collides = f.collides | (f.flies & to_float_mask(equal(layer, count)));
    f.flies = f.flies & to_float_mask(layer < count);
    y = select(f.flies, select(f.down, Real(0), lookup(t.layers->value[kDepth], layer)), y);
    return any(f.flies);
  }
  /// Moves y and the layer by a free flight, exactly across layers. Returns which lanes end at a
  /// collision, in a medium or with the substrate.
  LAMELLA_INLINE Mask fly(Vec3<Real> wi, Real remaining, Mask flies, Words& layer, Real& y) const {
    Flight flight = begin_flight(wi, remaining, flies, layer, y);
    while (cross(flight, wi, layer, y)) {
    }
    return flight.collides;
  }
};

}  // namespace lamella
