#pragma once

// Many walks on lanes through stacks with interfaces. Events in media and meetings with interfaces
// are steps of their own: light at an interface waits in a store until it fills a register. Only
// for sources of lamella_lanes().

#include "phase/lanes/lane_erf.h"
#include "volume/lanes/lane_boundaries.h"
#include "volume/lanes/lane_loop.h"
#include "volume/lanes/lane_stored_walks.h"

namespace lamella::LAMELLA_ISA {

template <int C>
using BoundedWalks = LaneWalks<C, BoundedState<Floats, C>>;

/// What one kind of step of all sets works on.
struct BoundedStep {
  FloatMask lanes[kSets];  ///< which take part
  int count[kSets] = {};
  LaneDraws<Floats> draws[kSets];
  AnyMedia<Floats>::Flight flights[kSets];
};

/// Numbers of the lanes that take part; the others keep theirs.
template <int C>
LAMELLA_INLINE void keep_others(const WalkNumbers<Words>& before, FloatMask drew,
                                BoundedState<Floats, C>& w) {
  const WordMask words = to_word_mask(drew);
  for (int k = 0; k < 4; ++k) w.numbers.s[k] = select(words, w.numbers.s[k], before.s[k]);
}

/// Flights of all sets, by turns.
template <int C, class Set>
LAMELLA_INLINE void fly_by_turns(const Set& set, BoundedWalks<C> (&all)[kSets], BoundedStep& step) {
  for (bool flying = true; flying;) {
    flying = false;
    for (int k = 0; k < kSets; ++k) {
      BoundedState<Floats, C>& w = all[k].state;
      if (any(step.flights[k].flies)) flying |= set.cross(step.flights[k], w.wi, w.layer, w.y);
    }
  }
}

/// Hands over walks that ended, `bits` telling how, and frees their lanes.
template <int C, class Set, class Score>
LAMELLA_INLINE void hand_over(const LoopSetting<C, Set, Score>& s, BoundedWalks<C>& walks,
                              FloatMask ends, Words bits,
                              typename LoopSetting<C, Set, Score>::Ended& ended,
                              LoopTotals& totals) {
  using Ended = typename LoopSetting<C, Set, Score>::Ended;
  BoundedState<Floats, C>& w = walks.state;
  totals.poison = multiply_add(w.wi.z, Floats(0), totals.poison);
  Words events = shift_left<Ended::kBits>(w.order) | bits;
  events = select(equal(w.met & Words(1u), Words(0u)), events | Words(kMetDeltasBit), events);
  if constexpr (C > 0) events = select(is_below(w.order, w.death), events, events | Words(2u));
  note_ends<C>(s, w, ends, events, ended);
  const int fallen = count(ends);
  ended.size += fallen;
  walks.free = walks.free | ends;
  walks.free_count += fallen;
  w.met = select(to_word_mask(ends), Words(0u), w.met);
  w.layer = select(to_word_mask(ends), Words(0u), w.layer);
}

/// Events of all walks, and the flights that follow.
template <int C, class Set, class Score>
LAMELLA_INLINE void collide(const LoopSetting<C, Set, Score>& s, BoundedWalks<C> (&all)[kSets],
                            typename LoopSetting<C, Set, Score>::Ended& ended, LoopTotals& totals) {
  BoundedStep step;
  LaneEnds<Floats> now[kSets];
  for (int k = 0; k < kSets; ++k) {
    BoundedWalks<C>& walks = all[k];
    BoundedState<Floats, C>& w = walks.state;
    step.lanes[k] = !walks.free;
    step.flights[k].flies = without(walks.free, walks.free);
    step.count[k] = kLanes - walks.free_count;
    if (step.count[k] == 0) continue;
    draw<C>(s.task.walk, s.set, w, step.draws[k]);
    now[k] = scatter<C>(s.task.walk, s.set, w, step.draws[k], step.lanes[k], s.score);
    w.met = select(to_word_mask(now[k].events), Words(0u), w.met);
    step.flights[k] = s.set.begin_flight(w.wi, step.draws[k].remaining,
                                         step.lanes[k] & now[k].lives, w.layer, w.y);
  }
  fly_by_turns<C>(s.set, all, step);
  for (int k = 0; k < kSets; ++k) {
    if (step.count[k] == 0) continue;
    const FloatMask ends = without(step.lanes[k], now[k].lives & step.flights[k].collides);
    hand_over<C>(s, all[k], ends, select(to_word_mask(now[k].lives), Words(0u), Words(1u)), ended,
                 totals);
    totals.events += static_cast<std::uint64_t>(count(now[k].events));
    totals.reflections += static_cast<std::uint64_t>(count(now[k].reflections));
    totals.carried += static_cast<std::uint64_t>(step.count[k]);
    ++totals.steps;
  }
}

/// The same in one layer of one medium, known at compile time, without weights.
template <class One, class Set, class Score>
LAMELLA_INLINE void collide_in(const One& one, const LoopSetting<0, Set, Score>& s,
                               BoundedWalks<0> (&all)[kSets],
                               typename LoopSetting<0, Set, Score>::Ended& ended,
                               LoopTotals& totals) {
  LaneDraws<Floats> draws[kSets];
  LaneEnds<Floats> now[kSets];
  FloatMask ends[kSets];
  const auto& shape = s.task.walk.boundaries->value[kShape];
  const FloatMask every = first_lanes<float>(kLanes), none = first_lanes<float>(0);
  const FloatMask above = shape[0] > 0 ? every : none, below = shape[1] > 0 ? every : none;
#pragma GCC unroll 4
  for (int k = 0; k < kSets; ++k) draw<0>(s.task.walk, one, all[k].state, draws[k]);
#pragma GCC unroll 4
  for (int k = 0; k < kSets; ++k)
    now[k] = scatter<0>(s.task.walk, one, all[k].state, draws[k], !all[k].free, s.score);
#pragma GCC unroll 4
  for (int k = 0; k < kSets; ++k) {
    BoundedState<Floats, 0>& w = all[k].state;
    const FloatMask flies = without(now[k].lives, all[k].free);
    const FloatMask inside = one.fly(w.wi, draws[k].remaining, flies, w.layer, w.y);
    const FloatMask down = w.wi.z > Floats(0);
    const FloatMask at = without(flies, inside) & ((down & below) | without(above, down));
    w.met = select(to_word_mask(now[k].events), Words(0u), w.met);
    const Words boundary = select(to_word_mask(down), Words(kAtBoundary + 1), Words(kAtBoundary));
    w.layer = select(to_word_mask(at), boundary, w.layer);
    ends[k] = without(!all[k].free, flies & (inside | at));
  }
  for (int k = 0; k < kSets; ++k) {
    const int active = kLanes - all[k].free_count;
    if (active == 0) continue;
    hand_over<0>(s, all[k], ends[k], select(to_word_mask(now[k].lives), Words(0u), Words(1u)),
                 ended, totals);
    totals.events += static_cast<std::uint64_t>(count(now[k].events));
    totals.carried += static_cast<std::uint64_t>(active);
    ++totals.steps;
  }
}

/// Walks through a stack of interfaces without media: what flies on is at the next interface, or at
/// the substrate.
template <int C, class Set, class Score>
[[gnu::noinline]] void unscattered_walks_of(const LaneWalkTask& t, const Score& score) {
  using Setting = LoopSetting<C, Set, Score>;
  const Set set(t.walk);
  const Setting s{t,     set,
                  score, {Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])},
                  false, first_lanes<float>(kLanes)};
  typename Setting::Pool pool;
  typename Setting::Ended ended;
  LoopTotals totals;
  std::uint64_t meetings = 0;
  BoundedWalks<C> all[kSets];
  for (BoundedWalks<C>& w : all) {
    empty(w, s.incident);
    w.state.met = Words(0u);
  }
  const Words at_substrate(static_cast<std::uint32_t>(t.walk.layer_count));
  const Words over_substrate = at_substrate + Words(kAtBoundary - 1);
  pool.fill(t, set);
  for (;;) {
    const int walking = take_walks(s, pool, all);
    if (walking == 0) break;
    if (walking <= kLanes && walking > kLanes - all[0].free_count) crowd(all);
    FloatMask ends[kSets];
    Words bits[kSets];
    for (int k = 0; k < kSets; ++k) {
      BoundedState<Floats, C>& w = all[k].state;
      const FloatMask active = !all[k].free;
      const FloatMask lanes = active & set.is_at_boundary(w.layer);
      const int met = count(lanes), walks = kLanes - all[k].free_count;
      ends[k] = without(active, active);
      bits[k] = Words(0u);
      if (met == 0) continue;
      const WalkNumbers<Words> before = w.numbers;
      Words words[kMostBoundaryWords];
      draw_meeting<Floats, C>(t.walk, t.walk.boundaries->words, lanes, w, words);
      if (met < walks) keep_others<C>(before, lanes, w);
      const BoundaryEnds<Floats> now = meet<AnyBoundaries, Floats, C>(t.walk, w, words, lanes);
      const FloatMask goes_on = set.hop(w.wi, now.lives, w.layer);
      ends[k] = without(lanes, goes_on);
      bits[k] = select(to_word_mask(now.lost), Words(kLostBit), Words(0u));
      bits[k] = select(to_word_mask(now.cut), Words(kCutBit), bits[k]);
      meetings += static_cast<std::uint64_t>(met);
      totals.carried += static_cast<std::uint64_t>(met);
      ++totals.steps;
    }
    for (int k = 0; t.walk.substrate && k < kSets; ++k) {
      BoundedState<Floats, C>& w = all[k].state;
      const FloatMask active = without(!all[k].free, ends[k]);
      const FloatMask lanes = active & to_float_mask(equal(w.layer, at_substrate));
      if (!any(lanes)) continue;
      const WalkNumbers<Words> before = w.numbers;
      LaneDraws<Floats> draws;
      draw<C>(t.walk, set, w, draws);
      if (any(without(active, lanes))) keep_others<C>(before, lanes, w);
      const LaneEnds<Floats> now = scatter<C>(t.walk, set, w, draws, lanes, score);
      w.met = select(to_word_mask(lanes), Words(0u), w.met);
      w.layer = select(to_word_mask(lanes), over_substrate, w.layer);
      const FloatMask gone = without(lanes, now.lives);
      ends[k] = ends[k] | gone;
      bits[k] = select(to_word_mask(gone), Words(1u), bits[k]);
      const auto met = static_cast<std::uint64_t>(count(lanes));
      totals.events += met;
      totals.reflections += static_cast<std::uint64_t>(count(now.reflections));
      totals.carried += met;
      ++totals.steps;
    }
    for (int k = 0; k < kSets; ++k)
      if (all[k].free_count < kLanes) hand_over<C>(s, all[k], ends[k], bits[k], ended, totals);
    if (ended.size >= Setting::Ended::kSize) ended.count_all(t);
  }
  LaneSums& sums = close(s, ended, totals);
  sums.events += totals.events;
  sums.meetings += meetings;
}

/// Loop through a stack with media: lanes hold walks that collide; those at interfaces are stored
/// until there are enough of them, as are those that come from there.
/// One: the only layer's medium, OneMedium, or void.
template <int C, class Set, class Score, class One>
struct QueuedWalks {
  using Setting = LoopSetting<C, Set, Score>;
  using State = BoundedState<Floats, C>;
  static constexpr int kMost = kSets * kLanes;
  const Setting& s;
  typename Setting::Pool pool;
  typename Setting::Ended ended;
  LoopTotals totals;
  std::uint64_t meetings = 0;
  StoredWalks<C, State, 4 * kMost, true, true> ready, waiting;
  BoundedWalks<C> all[kSets], packets[kSets];

  explicit QueuedWalks(const Setting& setting) : s(setting) {
    for (auto* walks : {&ready, &waiting})
      walks->has_point = walks->has_shift = s.task.walk.lattice != nullptr;
    for (BoundedWalks<C>* walks : {all, packets})
      for (int k = 0; k < kSets; ++k) {
        empty(walks[k], s.incident);
        walks[k].state.met = Words(0u);
      }
  }

  /// Sends walks on from where a flight or the entry left them.
  LAMELLA_INLINE void distribute(const State& w, FloatMask lanes) {
    const FloatMask at = lanes & s.set.is_at_boundary(w.layer);
    waiting.push(w, at);
    ready.push(w, without(lanes, at));
  }

  /// Walks for `ready`, until it can fill all lanes or there are no more.
  [[gnu::noinline]] void feed(int walking) {
    const LaneWalkTask& t = s.task;
    const FloatMask every = first_lanes<float>(kLanes), none = first_lanes<float>(0);
    while (ready.size < kMost) {
      BoundedStep step;
      BoundaryEnds<Floats> now[kSets];
      bool found = false;
      for (int k = 0; k < kSets; ++k) step.flights[k].flies = step.lanes[k] = none;
      for (int k = 0; k < kSets; ++k) {
        State& w = packets[k].state;
        if (pool.to - pool.from < kLanes) pool.fill(t, s.set);
        const int fresh = pool.to - pool.from;
        if (waiting.size >= kLanes ||
            (fresh == 0 && waiting.size > 0 && walking + ready.size <= kMost / 2)) {
          step.lanes[k] = waiting.pop(w, every);
        } else if (fresh > 0) {
          const int n = fresh < kLanes ? fresh : kLanes;
          step.lanes[k] = first_lanes<float>(n);
          refill<C>(pool, s.incident, w, step.lanes[k], Words::iota());
          w.met = Words(0u);
          pool.from += n;
          Words entry;
          if (!s.set.enters_at_boundary(entry)) {
            distribute(w, step.lanes[k]);
            step.lanes[k] = none;
            found = true;
            continue;
          }
        }
        step.count[k] = count(step.lanes[k]);
        if (step.count[k] == 0) break;
        found = true;
      }
      if (!found) return;
      for (int k = 0; k < kSets; ++k) {
        if (step.count[k] == 0) continue;
        State& w = packets[k].state;
        Words words[kMostBoundaryWords];
        draw_meeting<Floats, C>(t.walk, t.walk.boundaries->words, step.lanes[k], w, words);
        now[k] = meet<AnyBoundaries, Floats, C>(t.walk, w, words, step.lanes[k]);
        step.flights[k] =
            s.set.begin_flight(w.wi, exponential_of(words[0]), now[k].lives, w.layer, w.y);
      }
      fly_by_turns<C>(s.set, packets, step);
      for (int k = 0; k < kSets; ++k) {
        if (step.count[k] == 0) continue;
        const FloatMask goes_on = now[k].lives & step.flights[k].collides;
        Words bits = select(to_word_mask(now[k].lost), Words(kLostBit), Words(0u));
        bits = select(to_word_mask(now[k].cut), Words(kCutBit), bits);
        distribute(packets[k].state, goes_on);
        hand_over<C>(s, packets[k], without(step.lanes[k], goes_on), bits, ended, totals);
        meetings += static_cast<std::uint64_t>(step.count[k]);
        totals.carried += static_cast<std::uint64_t>(step.count[k]);
        ++totals.steps;
      }
      if (ended.size >= Setting::Ended::kSize) ended.count_all(t);
    }
  }

  /// Gives walks to free lanes; how many are on their way then.
  LAMELLA_INLINE int take() {
    int walking = 0;
    for (BoundedWalks<C>& w : all) {
      if (w.free_count > 0 && ready.size > 0) {
        const FloatMask taken = ready.pop(w.state, w.free);
        w.free = without(w.free, taken);
        w.free_count -= count(taken);
      }
      walking += kLanes - w.free_count;
    }
    return walking;
  }

  [[gnu::noinline]] void run() {
    const LaneWalkTask& t = s.task;
    int walking = 0;
    pool.fill(t, s.set);
    for (;;) {
      if (ready.size < kMost) feed(walking);
      walking = take();
      if (walking == 0 && waiting.size == 0) break;
      if (walking <= kLanes && walking > kLanes - all[0].free_count) crowd(all);
      if constexpr (std::is_void_v<One>)
        collide<C>(s, all, ended, totals);
      else
        collide_in(One(t.walk), s, all, ended, totals);
      for (BoundedWalks<C>& walks : all) {
        const FloatMask at = without(s.set.is_at_boundary(walks.state.layer), walks.free);
        if (!any(at)) continue;
        const int gone = count(at);
        waiting.push(walks.state, at);
        walks.state.layer = select(to_word_mask(at), Words(0u), walks.state.layer);
        walks.free = walks.free | at;
        walks.free_count += gone;
        walking -= gone;
      }
      if (ended.size >= Setting::Ended::kSize) ended.count_all(t);
    }
    LaneSums& sums = close(s, ended, totals);
    sums.events += totals.events;
    sums.meetings += meetings;
  }
};

/// The walks of a task through a stack with interfaces and media.
template <int C, class Set, class Score, class One = void>
[[gnu::noinline]] void queued_walks_of(const LaneWalkTask& t, const Score& score) {
  const Set set(t.walk);
  const LoopSetting<C, Set, Score> s{
      t,     set,
      score, {Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])},
      false, first_lanes<float>(kLanes)};
  QueuedWalks<C, Set, Score, One>(s).run();
}

}  // namespace lamella::LAMELLA_ISA
