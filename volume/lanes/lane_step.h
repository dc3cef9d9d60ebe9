#pragma once

// One step of walks: an event, and the flight to the next one. A template over the number type, so
// that lanes of float and the double that they are held against (volume/lanes/lane_replay.h) are
// the same walk with the same random numbers.

#include "phase/math/color.h"
#include "phase/random/lattice.h"
#include "volume/lanes/lane_media.h"
#include "volume/result/thinning.h"

namespace lamella {

/// Random streams of a walk on lanes, beside those of StreamPurpose: one gives the state that its
/// generator begins from, one the place within cells that an event's light is sent to.
inline constexpr std::uint32_t kLaneWalkStream = 4, kLaneTargetStream = 6;

/// What became of a walk.
enum class WalkEnd : std::uint32_t { up = 0, down = 1, absorbed = 2, unresolved = 3, thinned = 4 };
inline constexpr int kWalkEnds = 5;
/// Walks through boundaries have three rows more (volume/lanes/lane_boundaries.h).
template <bool kBounded>
inline constexpr int kEndRows = kBounded ? kWalkEnds + 3 : kWalkEnds;
inline constexpr int kLostRow = kWalkEnds;       ///< in the shadow of facets
inline constexpr int kDeltaRow = kWalkEnds + 1;  ///< left up, and down, by smooth boundaries alone
/// The row of light that goes straight through.
template <bool kBounded>
[[nodiscard]] LAMELLA_INLINE constexpr int straight_row(bool from_above) {
  return (kBounded ? kDeltaRow : 0) + (from_above ? 1 : 0);
}
/// Bits of a walk's end beside its order, through boundaries.
inline constexpr int kBoundedBits = 5;
inline constexpr std::uint32_t kLostBit = 4, kMetDeltasBit = 8, kCutBit = 16;
/// The highest order that leaves room for them.
inline constexpr std::uint64_t kMostBoundedOrder = 100000000;
/// The order from which on walks end by roulette: kTallyOrders.
inline constexpr std::uint32_t kRouletteOrder = 4;

template <class Scalar>
struct BoundaryNumbers;

/// A stack and its light as walks on lanes know them.
template <class Scalar>
struct WalkSetting {
  const LayerNumbers<Scalar>* layers = nullptr;
  int layer_count = 0;
  unsigned kinds = 0;  ///< bit LaneMediumKind: there is a layer of it, or a substrate
  bool substrate = false, fresnel = false, from_above = true;
  bool grey = true;      ///< all channels are the same
  bool upright = false;  ///< all matrices are UprightSggxMatrix's
  Scalar wi[3] = {};
  bool collides_at_once = false;  ///< as good as every walk meets something
  /// Above 0: every walk collides; this is the chance that it would.
  Scalar forced_chance = 0;
  /// Walks without weights: 1 / -log(albedo), infinity at albedo 1. From the fourth event on a walk
  /// survives with the albedo.
  Scalar orders_per_absorption = 0;
  bool black = false;  ///< the first event ends a walk
  /// Walks without weights: what an event ends is absorbed, at the fourth event or later.
  bool ends_absorb = false;
  bool by_layer = false;         ///< all lanes walk in one layer at a time, see walks_by_layer
  bool null_collisions = false;  ///< the medium is one of volume/lanes/lane_null_flakes.h
  Scalar substrate_albedo[3] = {};
  std::uint32_t max_order = 0;
  std::uint32_t thinned_from = 0;  ///< Thinning::first
  int words = 1;  ///< random words that an event takes: the most that any of the media needs
  std::uint64_t seed = 0;
  const LatticeNumbers* lattice = nullptr;  ///< of the first steps; none: all words are random
  const BoundaryNumbers<Scalar>* boundaries = nullptr;  ///< of stacks with interfaces
};

/// Walks, one per lane. C: weights that they carry, 3, or 0 where the order alone tells them.
template <class Real, int C>
struct LaneState {
  Vec3<Real> wi;  ///< points back to where the light comes from
  Real y;         ///< depth below the layer's top
  WordsOf<Real> layer, order, index;
  /// The event that ends the walk, as one too many or by thinning; without weights by roulette,
  /// too.
  WordsOf<Real> death;
  WalkNumbers<WordsOf<Real>> numbers;
  /// With a lattice: the walk's point, its batch's shift where walks of several batches share the
  /// lanes, and the steps that it has taken, where they are not its order.
  WordsOf<Real> point, shift, step;
  Real weight[C > 0 ? C : 1];
};

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
    visit_kind<VmfMirrorOnLanes<Real>>(layer, kind, f);
    visit_kind<VmfLambertOnLanes<Real>>(layer, kind, f);
    visit_kind<SubstrateOnLanes<Real>>(layer, kind, f);
  }

  LAMELLA_INLINE Real inverse_area(Words layer, Vec3<Real> w) const {
    const LayerPerLane<Real> numbers{*t.layers, layer};
    Real inverse(1);
    if (has_sggx)  // particles have the unit matrix
      inverse = t.upright ? SggxOnLanes<Real, UprightSggxMatrix>(numbers).inverse_area(w)
                          : SggxOnLanes<Real, SggxMatrix>(numbers).inverse_area(w);
    if (!has_vmf) return inverse;
    return select(numbers(kWidth) > Real(0), VmfOnLanes<Real>(numbers).inverse_area(w), inverse);
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

/// Scores nothing.
struct NoScore {
  static constexpr bool kUsesIndex = false;
  LAMELLA_INLINE void finish() const {}
  template <class All, class M, class Real, class State, class Mask>
  LAMELLA_INLINE void operator()(All, const M&, const LaneEvent<Real>&, const State&, Mask) const {}
};

/// Scores nothing, but the loop must know the walks' indices (to tell batches apart).
struct NoScoreByIndex : NoScore {
  static constexpr bool kUsesIndex = true;
};

/// How walks end in a step.
template <class Real>
struct LaneEnds {
  MaskOf<Real> lives;        ///< which walks the event left to fly on
  MaskOf<Real> ends;         ///< which ended, by the event or in the flight
  MaskOf<Real> gone;         ///< by the event; otherwise it left the stack
  MaskOf<Real> events;       ///< which lanes met an event
  MaskOf<Real> reflections;  ///< the substrate's among them
};

/// How a walk ended, and after how many events that count. An event beyond max_order does not
/// count and leaves the walk unresolved.
template <class Words>
struct LaneEnd {
  Words end, order;  ///< WalkEnd; events that counted
  template <class Mask>
  LAMELLA_INLINE LaneEnd(Words events, Mask gone, Mask down, std::uint32_t max_order) {
    const Words most(max_order);
    order = min(events, most);
    end = select(gone, Words(2u), select(down, Words(1u), Words(0u)));
    end = select(is_below(most, events), Words(3u), end);
  }
};

/// The weights after an event of order w.order, given what it keeps: survival from the fourth event
/// on has the chance of the brightest channel. Which of the lanes `counts` end. Others keep theirs.
template <class Real>
[[nodiscard]] LAMELLA_INLINE MaskOf<Real> weigh(LaneState<Real, 3>& w, const Real* kept, bool grey,
                                                MaskOf<Real> counts, Real uniform) {
  Real on[3], before = Real(0), after = Real(0);
  for (int c = 0; c < 3; ++c) {
    on[c] = w.weight[c] * kept[c];
    before = max(before, w.weight[c]);
    after = max(after, on[c]);
  }
  const auto late = to_float_mask(is_below(WordsOf<Real>(kRouletteOrder - 1), w.order));
  const auto gone = counts & ((late & (uniform * before >= after)) | (after <= Real(0)));
  const Real scale = before / max(after, Real(1e-30));
  for (int c = 0; c < 3; ++c) {
    // Grey: with the weight it had, to the last bit.
    const Real survivor = grey ? w.weight[c] : on[c] * scale;
    w.weight[c] = select(counts, select(late, survivor, on[c]), w.weight[c]);
  }
  return gone;
}

/// Steps that walks have taken before this one: their events, unless others are among them.
template <bool kCountsSteps, int C, class Real>
[[nodiscard]] LAMELLA_INLINE WordsOf<Real> steps_taken(const LaneState<Real, C>& w) {
  if constexpr (kCountsSteps)
    return w.step;
  else
    return w.order;
}

/// What a step draws before anything happens.
template <class Real>
struct LaneDraws {
  WordsOf<Real> words[kEventWords];
  Real remaining;  ///< mean free paths to the next collision
};
template <int C, class Set, class Real>
LAMELLA_INLINE void draw(const WalkSetting<typename NumberTraits<Real>::Scalar>& t, const Set& set,
                         LaneState<Real, C>& w, LaneDraws<Real>& draws) {
  using Words = WordsOf<Real>;
  int used = set.words();
  if constexpr (requires { Set::kWords; }) used = Set::kWords;
  for (int k = 0; k < used; ++k) draws.words[k] = w.numbers.next();
  if constexpr (requires { Set::kWords; })  // others may need more
    for (int k = used; k < set.words(); ++k) w.numbers.next();
  if constexpr (C > 0) draws.words[kRouletteWord] = w.numbers.next();
  if (t.lattice != nullptr) {
    const Words step = steps_taken<Set::kCountsSteps>(w);
    const auto early = is_below(step, Words(kLatticeSteps));
    const auto replace = [&](int k) LAMELLA_INLINE_LAMBDA {
      draws.words[k] =
          select(early, lattice_word(*t.lattice, k, step, w.point, w.shift), draws.words[k]);
    };
    for (int k = 0; k < used; ++k) replace(k);
    if constexpr (C > 0) replace(kRouletteWord);
  }
  draws.remaining = exponential_of(draws.words[0]);
}

/// All active lanes are at a collision, or a null one: the event.
/// score(what lanes have in common, medium, event, walks, lanes) sees events before they count;
/// those at max_order are one too many. kFull: all lanes are active, and of a single medium.
template <int C, bool kFull = false, class Set, class Real, class Score>
LAMELLA_INLINE LaneEnds<Real> scatter(const WalkSetting<typename NumberTraits<Real>::Scalar>& t,
                                      const Set& set, LaneState<Real, C>& w,
                                      const LaneDraws<Real>& draws, MaskOf<Real> active,
                                      const Score& score) {
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  // Every lane meets an event.
  constexpr bool kEvery = kFull && Set::kSingle && !kRefuses<Set>;
  Mask events = active, reflections = without(active, active);
  if constexpr (!Set::kSingle) events = reflections;
  Vec3<Real> wi = w.wi;
  Real kept[C > 0 ? C : 1];
  if constexpr (C > 0)
    for (Real& k : kept) k = Real(1);
  set.visit(w.layer, [&](const auto& medium, auto all, Mask here) LAMELLA_INLINE_LAMBDA {
    using M = std::remove_cvref_t<decltype(medium)>;
    using All = decltype(all);
    const auto event = medium.collide(w.wi, draws.words);
    Mask scatters = active;
    if constexpr (!All::kSame) scatters = scatters & here;
    if constexpr (kRefuses<M>) scatters = kFull ? event.accepted : scatters & event.accepted;
    if constexpr (All::kSame)
      events = scatters;
    else
      events = events | scatters;
    if constexpr (M::kKind == LaneMediumKind::substrate)
      reflections = scatters & to_float_mask(is_below(w.order, Words(t.max_order)));
    score(all, medium, event, w, scatters);
    const auto scattered = medium.sample(event, draws.words);
    if constexpr (All::kSame && !kRefuses<M>)
      wi = scattered.next;  // what is not active does not matter
    else
      wi = select(scatters, scattered.next, wi);
    if constexpr (C > 0) {
      constexpr bool substrate = M::kKind == LaneMediumKind::substrate;
      const auto layers = set.numbers(t, w.layer);
      for (int c = 0; c < C; ++c) {
        Real k = substrate ? Real(t.substrate_albedo[c]) : layers(kAlbedo + c);
        if (M::kMirror && t.fresnel) {
          const Real f0 = layers(kF0 + c);
          k = k * multiply_add(schlick_weight(scattered.cosine), Real(1) - f0, f0);
        }
        kept[c] = select(scatters, k, kept[c]);
      }
    }
  });
  if constexpr (Set::kCountsSteps)
    w.step = w.step + select(to_word_mask(active), Words(1u), Words(0u));
  w.order = w.order + (kEvery ? Words(1u) : select(to_word_mask(events), Words(1u), Words(0u)));
  w.wi = wi;
  Mask lives;
  if constexpr (C > 0) {
    const Mask over = without(events, to_float_mask(is_below(w.order, w.death)));
    lives = !(over | weigh(w, kept, t.grey, without(events, over),
                           uniform_of(draws.words[kRouletteWord])));
  } else {
    lives = to_float_mask(is_below(w.order, w.death));
  }
  return {lives, !lives, !lives, events, reflections};
}

/// The flight that follows, which tells `now.ends`.
template <int C, bool kFull = false, class Set, class Real>
LAMELLA_INLINE void fly(const Set& set, LaneState<Real, C>& w, const LaneDraws<Real>& draws,
                        MaskOf<Real> active, LaneEnds<Real>& now) {
  using Mask = MaskOf<Real>;
  const Mask flies = kFull ? now.lives : active & now.lives;
  const Mask goes_on = flies & set.fly(w.wi, draws.remaining, flies, w.layer, w.y);
  now.ends = kFull ? !goes_on : without(active, goes_on);
}

/// A step of all active lanes.
template <int C, class Set, class Real, class Score>
LAMELLA_INLINE LaneEnds<Real> step(const WalkSetting<typename NumberTraits<Real>::Scalar>& t,
                                   const Set& set, LaneState<Real, C>& w, MaskOf<Real> active,
                                   const Score& score) {
  LaneDraws<Real> draws;
  draw(t, set, w, draws);
  LaneEnds<Real> now = scatter(t, set, w, draws, active, score);
  fly(set, w, draws, active, now);
  return now;
}

/// Begins walks of light from w_i by the numbers w.numbers and the point w.point: their first
/// flight. Which of them
/// collide; the others leave the stack as they came.
template <int C, class Set, class Real>
LAMELLA_INLINE MaskOf<Real> begin_from(Vec3<Real> wi,
                                       const WalkSetting<typename NumberTraits<Real>::Scalar>& t,
                                       const Set& set, LaneState<Real, C>& w, MaskOf<Real> exist) {
  using Words = WordsOf<Real>;
  const auto drawn = [&](int word) LAMELLA_INLINE_LAMBDA {
    const Words random = w.numbers.next();
    if (t.lattice == nullptr) return random;
    return lattice_beginning(*t.lattice, word, w.point, w.shift);
  };
  const Words flight = drawn(0);
  w.step = Words(0u);
  w.wi = wi;
  const int start = t.from_above ? 0 : t.layer_count - 1;
  w.layer = Words(static_cast<std::uint32_t>(start));
  const Real bottom = Real(t.layers->value[kDepth][start]);
  w.y = t.from_above ? Real(0) : bottom;
  w.order = Words(0u);
  for (Real& weight : w.weight) weight = Real(1);
  w.death = Words(t.max_order + 1);
  if constexpr (C == 0) {
    // The event at which the roulette of the fourth and later ones ends the walk.
    const Real survived = min(exponential_of(drawn(1)) * Real(t.orders_per_absorption), Real(1e9));
    w.death = min(w.death, t.black ? Words(1u) : word_of(survived) + Words(kRouletteOrder));
  }
  if (t.thinned_from > 0) w.death = min(w.death, thinned_at(t.thinned_from, drawn(2)));
  if constexpr (Set::kBounded) {
    Words entry;
    if (set.enters_at_boundary(entry)) {
      w.layer = entry;
      return exist;
    }
  }
  if (!(t.forced_chance > 0))
    return set.fly(w.wi, exponential_of(flight), exist, w.layer, w.y) & exist;
  // -log(1 - x) by its series, x the uniform number times the chance
  const Real x = fine_uniform_of(flight) * Real(t.forced_chance);
  Real p = multiply_add(x, Real(0.2), Real(0.25));
  p = multiply_add(x, p, Real(1.0 / 3));
  p = multiply_add(x, p, Real(0.5));
  const auto inside = set.fly(w.wi, multiply_add(x * x, p, x), exist, w.layer, w.y);
  // What rounding sends out has its collision at the end of the way.
  const int last = t.from_above ? t.layer_count - 1 : 0;
  const auto out = !inside;
  w.layer = select(to_word_mask(out), Words(static_cast<std::uint32_t>(last)), w.layer);
  w.y = select(out, t.from_above ? Real(t.layers->value[kDepth][last]) : Real(0), w.y);
  return exist;
}

/// Begins walks of the setting's light.
template <int C, class Set, class Real>
LAMELLA_INLINE MaskOf<Real> begin(const WalkSetting<typename NumberTraits<Real>::Scalar>& t,
                                  const Set& set, LaneState<Real, C>& w, MaskOf<Real> exist) {
  return begin_from<C>({Real(t.wi[0]), Real(t.wi[1]), Real(t.wi[2])}, t, set, w, exist);
}

/// Up to this chance of a first collision it is forced (the series for it is 1e-7 off there).
inline constexpr double kForcedChance = 0.05;

}  // namespace lamella
