#pragma once

// One step of walks: an event, and the flight to the next one. A template over the number type, so
// that lanes of float and the double that they are held against (volume/lanes/lane_replay.h) are
// the same walk with the same random numbers.

#include "phase/math/color.h"
#include "volume/lanes/lane_sets.h"
#include "volume/result/thinning.h"

namespace lamella {

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

/// Up to this chance of a first collision its place is a series (1e-7 off there); other stacks than
/// those whose first flights are forced anyway force none beyond.
inline constexpr double kForcedChance = 0.05;

/// The mean free paths to a first collision of that chance, by the uniform word.
template <class Real, class Scalar>
[[nodiscard]] LAMELLA_INLINE Real first_length(Scalar chance, Scalar rest, WordsOf<Real> word) {
  using std::log;
  const Real u = fine_uniform_of(word);
  if (chance > static_cast<Scalar>(kForcedChance))
    return -log(multiply_add(u, Real(chance), Real(rest)));
  // -log(1 - x) by its series
  const Real x = u * Real(chance);
  Real p = multiply_add(x, Real(0.2), Real(0.25));
  p = multiply_add(x, p, Real(1.0 / 3));
  p = multiply_add(x, p, Real(0.5));
  return multiply_add(x * x, p, x);
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
  const auto inside = set.fly(w.wi, first_length<Real>(t.forced_chance, t.forced_rest, flight),
                              exist, w.layer, w.y);
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

}  // namespace lamella
