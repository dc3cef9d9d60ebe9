#pragma once

// Many walks on lanes: a lane takes the next walk as soon as its own has ended. Only for sources of
// lamella_lanes().

#include "volume/lanes/ended_walks.h"
#include "volume/lanes/lane_forced_flights.h"
#include "volume/lanes/lane_pool.h"

namespace lamella::LAMELLA_ISA {

/// A set of lanes.
template <int C, class State = LaneState<Floats, C>>
struct LaneWalks {
  State state;
  FloatMask free;  // lanes without a walk
  int free_count;
};

/// Moves all walks to the first set, which has room for them: the last ones are long, and a step
/// costs as much for one of them as for all of a set.
template <int C, class State>
[[gnu::noinline]] void crowd(LaneWalks<C, State> (&all)[kSets]) {
  struct Move {
    int set, from, to;
  };
  Move moves[kLanes];
  int count = 0;
  std::uint32_t room = mask_bits(all[0].free);
  for (int k = 1; k < kSets; ++k)
    for (std::uint32_t left = mask_bits(!all[k].free); left != 0; left &= left - 1) {
      moves[count++] = {k, __builtin_ctz(left), __builtin_ctz(room)};
      room &= room - 1;
    }
  const auto move = [&](auto number_of) {
    auto& first = number_of(all[0].state);
    using Number = std::remove_reference_t<decltype(first)>;
    alignas(64) typename Number::ScalarType of[kSets][kLanes];
    for (int k = 0; k < kSets; ++k) number_of(all[k].state).store(of[k]);
    for (const Move* m = moves; m < moves + count; ++m) of[0][m->to] = of[m->set][m->from];
    first = Number::load(of[0]);
  };
  move([](State & w) -> auto& { return w.wi.x; });
  move([](State & w) -> auto& { return w.wi.y; });
  move([](State & w) -> auto& { return w.wi.z; });
  move([](State & w) -> auto& { return w.y; });
  move([](State & w) -> auto& { return w.layer; });
  move([](State & w) -> auto& { return w.order; });
  move([](State & w) -> auto& { return w.index; });
  move([](State & w) -> auto& { return w.death; });
  for (int k = 0; k < 4; ++k) move([k](State & w) -> auto& { return w.numbers.s[k]; });
  for (int c = 0; c < std::max(C, 1); ++c) move([c](State & w) -> auto& { return w.weight[c]; });
  move([](State & w) -> auto& { return w.point; });
  move([](State & w) -> auto& { return w.shift; });
  move([](State & w) -> auto& { return w.step; });
  if constexpr (requires(State w) { w.met; }) move([](State & w) -> auto& { return w.met; });
  for (int k = 1; k < kSets; ++k) {
    all[k].free = first_lanes<float>(kLanes);
    all[k].free_count = kLanes;
  }
  alignas(64) float is_free[kLanes];
  for (int k = 0; k < kLanes; ++k) is_free[k] = static_cast<float>(room >> k & 1u);
  all[0].free = Floats::load(is_free) > Floats(0);
  all[0].free_count -= count;
}

/// What a loop of walks has met, over all of its steps.
struct LoopTotals {
  std::uint64_t steps = 0;        ///< of sets
  std::uint64_t carried = 0;      ///< lanes that had a walk at a step
  std::uint64_t events = 0;       ///< where steps are others, too: null or with interfaces
  std::uint64_t reflections = 0;  ///< at the substrate
  // 0, or not a number from the first such direction on: what is wrong with x or y is at the next
  // event wrong with z, and at the last one count_all sees it, unless the walk was absorbed by it
  // and went nowhere. Depths follow: they are never 0 times infinity, as 1 / sigma and lengths of
  // flights are finite.
  Floats poison{0};
};

/// What every step of a loop of walks works with.
template <int C, class Set, class Score>
struct LoopSetting {
  const LaneWalkTask& task;
  const Set& set;
  const Score& score;
  Vec3<Floats> incident;
  /// Whether what roulette ended is all alike: then no one looks at it, it is the rest.
  bool absorbs;
  FloatMask tells_gone;  ///< no lane where it absorbs, else every lane

  using Pool = LanePool<C, Set, Score>;
  using Ended = EndedWalks<C, Score::kUsesIndex, Set::kBounded>;
};

/// Lanes without a walk yet.
template <int C, class State>
LAMELLA_INLINE void empty(LaneWalks<C, State>& walks, Vec3<Floats> incident) {
  LaneState<Floats, C>& w = walks.state;
  w.wi = incident;
  w.y = Floats(0);
  w.layer = w.order = w.index = w.point = w.shift = w.step = Words(0u);
  w.numbers.s[0] = w.numbers.s[1] = Words(0u);
  w.numbers.s[2] = w.numbers.s[3] = Words(0u);
  w.death = Words(1u);
  for (Floats& weight : w.weight) weight = Floats(1);
  walks.free = first_lanes<float>(kLanes);
  walks.free_count = kLanes;
}

/// Gives walks of the pool to the lanes `take`, the first of them those of place `rank`. kWhole:
/// walks without weights begin as a whole, of which flights that are forced take shares.
template <int C, bool kWhole = false, class Pool>
LAMELLA_INLINE void refill(const Pool& pool, Vec3<Floats> incident, LaneState<Floats, C>& w,
                           FloatMask take, Words rank) {
  const WordMask words = to_word_mask(take);
  const auto word = [&](const std::uint32_t* from, Words old) LAMELLA_INLINE_LAMBDA {
    return select(words, permute(Words::load(from + pool.from), rank), old);
  };
  for (int k = 0; k < 4; ++k) w.numbers.s[k] = word(pool.numbers[k], w.numbers.s[k]);
  if constexpr (Pool::kIndex) w.index = word(pool.index, w.index);
  w.death = word(pool.death, w.death);
  if constexpr (Pool::kLayer) w.layer = word(pool.layer, w.layer);
  w.y = select(take, permute(Floats::load(pool.y + pool.from), rank), w.y);
  w.order = select(words, Words(0u), w.order);
  if (pool.lattice) {
    w.point = word(pool.point, w.point);
    w.shift = word(pool.shift, w.shift);
    w.step = select(words, Words(pool.first_step), w.step);
  }
  if constexpr (C > 0 || kWhole)
    for (Floats& weight : w.weight) weight = select(take, Floats(1), weight);
  Vec3<Floats> light = incident;
  if (pool.draws) {
    const auto number = [&](const float* from) LAMELLA_INLINE_LAMBDA {
      return permute(Floats::load(from + pool.from), rank);
    };
    light = {number(pool.wi[0]), number(pool.wi[1]), number(pool.wi[2])};
  }
  w.wi = select(take, light, w.wi);
}

/// Notes behind the walks that have ended those of the lanes `tells`, with their `events`.
template <int C, class Set, class Score, class State>
LAMELLA_INLINE void note_ends(const LoopSetting<C, Set, Score>& s, const State& w, FloatMask tells,
                              Words events, typename LoopSetting<C, Set, Score>::Ended& ended) {
  const int at = ended.size;
  store_compressed(events, tells, ended.events + at);
  if constexpr (Score::kUsesIndex)
    if (s.task.asks_for_index()) store_compressed(w.index, tells, ended.index + at);
  store_compressed(w.wi.z, tells, ended.z + at);
  if (counts_in_cells<Set::kBounded>(s.task) || s.task.estimate == LaneEstimate::walk_by_walk) {
    store_compressed(w.wi.x, tells, ended.x + at);
    store_compressed(w.wi.y, tells, ended.y + at);
  }
  if constexpr (C > 0)
    for (int c = 0; c < C; ++c) store_compressed(w.weight[c], tells, ended.weight[c] + at);
  if constexpr (C == 0 && forces_flights<Set, Score>())
    if (s.task.walk.forced_flights > 0) store_compressed(w.weight[0], tells, ended.weight[0] + at);
}

/// The flight that follows an event, forced where the setting asks for that.
template <bool kFull, int C, class Set, class Score>
LAMELLA_INLINE void fly_on(const LoopSetting<C, Set, Score>& s, LaneState<Floats, C>& w,
                           const LaneDraws<Floats>& draws, FloatMask active,
                           LaneEnds<Floats>& now) {
  if constexpr (C == 0 && Set::kSingle && forces_flights<Set, Score>())
    if (s.task.walk.forced_flights > 0)
      return fly_forced<kFull>(s.task.walk, s.set, w, draws, active, now, s.score);
  fly<C, kFull>(s.set, w, draws, active, now);
}

/// What a loop leaves in its batch when all walks have ended, the last of them counted here.
template <int C, class Set, class Score>
LAMELLA_INLINE LaneSums& close(const LoopSetting<C, Set, Score>& s,
                               typename LoopSetting<C, Set, Score>::Ended& ended,
                               const LoopTotals& totals) {
  ended.count_all(s.task);
  LaneSums& sums = *s.task.batches[0].sums;
  ended.add_counts(sums);
  s.score.finish();
  sums.lane_steps += totals.steps * static_cast<std::uint64_t>(kLanes);
  sums.busy_lane_steps += totals.carried;
  sums.reflections += totals.reflections;
  sums.finite = sums.finite && ended.finite && !any(!equal(totals.poison, Floats(0)));
  return sums;
}

/// Hands walks that ended at a step over to `ended` and frees their lanes. kFull: every lane had a
/// walk.
template <bool kFull, int C, class Set, class Score>
LAMELLA_INLINE void count_ends(const LoopSetting<C, Set, Score>& s, LaneWalks<C>& walks,
                               const LaneEnds<Floats>& now, FloatMask active,
                               typename LoopSetting<C, Set, Score>::Ended& ended,
                               LoopTotals& totals) {
  using Ended = typename LoopSetting<C, Set, Score>::Ended;
  LaneState<Floats, C>& w = walks.state;
  totals.poison = multiply_add(w.wi.z, Floats(0), totals.poison);
  FloatMask tells = now.ends;
  if constexpr (C == 0) tells = now.ends & (now.lives | s.tells_gone);
  Words events = shift_left<Ended::kBits>(w.order);
  events = select(to_word_mask(now.gone), events | Words(1u), events);
  if constexpr (C > 0) events = select(is_below(w.order, w.death), events, events | Words(2u));
  note_ends<C>(s, w, tells, events, ended);
  const int fallen = count(now.ends);
  ended.size += C == 0 ? count(tells) : fallen;
  if constexpr (kFull) {
    walks.free = now.ends;
    walks.free_count = fallen;
  } else {
    walks.free = walks.free | now.ends;
    walks.free_count += fallen;
  }
  totals.carried += static_cast<std::uint64_t>(kFull ? kLanes : count(active));
  if constexpr (kRefuses<Set>) totals.events += static_cast<std::uint64_t>(count(now.events));
  if constexpr (!Set::kSingle)
    totals.reflections += static_cast<std::uint64_t>(count(now.reflections));
}

/// Walks in one layer for as long as there are new ones for every lane: all sets take one part of
/// a step after the other.
template <int C, class Set, class Score>
LAMELLA_INLINE void lockstep(const LoopSetting<C, Set, Score>& s,
                             typename LoopSetting<C, Set, Score>::Pool& pool,
                             LaneWalks<C> (&all)[kSets],
                             typename LoopSetting<C, Set, Score>::Ended& ended,
                             LoopTotals& totals) {
  using Ended = typename LoopSetting<C, Set, Score>::Ended;
  const LaneWalkTask& t = s.task;
  for (;;) {
    constexpr int kMost = kSets * kLanes;
    if (pool.to - pool.from < kMost) pool.fill(t, s.set);
    if (pool.to - pool.from < kMost) break;
#pragma GCC unroll 4
    for (LaneWalks<C>& w : all) {
      refill<C, forces_flights<Set, Score>()>(pool, s.incident, w.state, w.free, rank_of(w.free));
      pool.from += w.free_count;
    }
    LaneDraws<Floats> draws[kSets];
    LaneEnds<Floats> now[kSets];
    const FloatMask every = first_lanes<float>(kLanes);
#pragma GCC unroll 4
    for (int k = 0; k < kSets; ++k) draw(t.walk, s.set, all[k].state, draws[k]);
#pragma GCC unroll 4
    for (int k = 0; k < kSets; ++k)
      now[k] = scatter<C, true>(t.walk, s.set, all[k].state, draws[k], every, s.score);
#pragma GCC unroll 4
    for (int k = 0; k < kSets; ++k) fly_on<true>(s, all[k].state, draws[k], every, now[k]);
#pragma GCC unroll 4
    for (int k = 0; k < kSets; ++k) count_ends<true>(s, all[k], now[k], every, ended, totals);
    if (ended.size >= Ended::kSize) ended.count_all(t);
    totals.steps += kSets;
  }
}

/// Gives new walks to free lanes, while there are any; how many walks are on their way then.
template <int C, class Set, class Score, class Pool, class State>
LAMELLA_INLINE int take_walks(const LoopSetting<C, Set, Score>& s, Pool& pool,
                              LaneWalks<C, State> (&all)[kSets]) {
  int walking = 0;
  for (LaneWalks<C, State>& w : all) {
    const int available = pool.to - pool.from;
    const Words rank = rank_of(w.free);
    FloatMask take = w.free;
    if (available < kLanes)
      take = take & to_float_mask(is_below(rank, Words(static_cast<std::uint32_t>(available))));
    refill<C, forces_flights<Set, Score>()>(pool, s.incident, w.state, take, rank);
    const int taken = count(take);
    pool.from += taken;
    if (pool.to - pool.from < kLanes) pool.fill(s.task, s.set);
    w.free = without(w.free, take);
    w.free_count -= taken;
    walking += kLanes - w.free_count;
  }
  return walking;
}

/// One step of all sets, one set after the other.
template <int C, class Set, class Score>
LAMELLA_INLINE void set_by_set(const LoopSetting<C, Set, Score>& s, LaneWalks<C> (&all)[kSets],
                               typename LoopSetting<C, Set, Score>::Ended& ended,
                               LoopTotals& totals) {
  for (LaneWalks<C>& w : all) {
    if (w.free_count == kLanes) continue;
    const FloatMask active = !w.free;
    LaneDraws<Floats> draws;
    draw(s.task.walk, s.set, w.state, draws);
    LaneEnds<Floats> now = scatter(s.task.walk, s.set, w.state, draws, active, s.score);
    fly_on<false>(s, w.state, draws, active, now);
    count_ends<false>(s, w, now, active, ended, totals);
    ++totals.steps;
  }
}

/// One step of all sets through several layers: their flights cross layers by turns.
template <int C, class Set, class Score>
LAMELLA_INLINE void by_turns(const LoopSetting<C, Set, Score>& s, LaneWalks<C> (&all)[kSets],
                             typename LoopSetting<C, Set, Score>::Ended& ended,
                             LoopTotals& totals) {
  constexpr bool kForces = C == 0 && forces_flights<Set, Score>();
  const bool forces = kForces && s.task.walk.forced_flights > 0;
  typename Set::Flight flights[kSets];
  LaneEnds<Floats> now[kSets];
  ForcedShare shares[kForces ? kSets : 1];
  for (int k = 0; k < kSets; ++k) {
    const FloatMask active = !all[k].free;
    flights[k].flies = without(active, active);
    if (all[k].free_count == kLanes) continue;
    LaneState<Floats, C>& w = all[k].state;
    LaneDraws<Floats> draws;
    draw(s.task.walk, s.set, w, draws);
    now[k] = scatter(s.task.walk, s.set, w, draws, active, s.score);
    if constexpr (kForces) {
      if (forces) {
        shares[k] = force(s.task.walk, w, draws, active & now[k].lives, now[k], s.score,
                          [&](FloatMask down) { return depth_to_exit(s.set, w, down); });
        draws.remaining = shares[k].remaining;
      }
    }
    flights[k] = s.set.begin_flight(w.wi, draws.remaining, active & now[k].lives, w.layer, w.y);
  }
  for (bool flying = true; flying;) {
    flying = false;
    for (int k = 0; k < kSets; ++k) {
      LaneState<Floats, C>& w = all[k].state;
      if (any(flights[k].flies)) flying |= s.set.cross(flights[k], w.wi, w.layer, w.y);
    }
  }
  for (int k = 0; k < kSets; ++k) {
    if (all[k].free_count == kLanes) continue;
    const FloatMask active = !all[k].free;
    if constexpr (kForces)
      if (forces) keep_inside(s.set, all[k].state, shares[k], now[k].lives, flights[k]);
    now[k].ends = without(active, flights[k].collides);
    count_ends<false>(s, all[k], now[k], active, ended, totals);
    ++totals.steps;
  }
}

/// The walks of a task. The numbers of a walk are those of (seed, walk), so that it does not matter
/// when and where it happens.
template <int C, class Set, class Score>
[[gnu::noinline]] void walks_of(const LaneWalkTask& t, const Score& score) {
  using Setting = LoopSetting<C, Set, Score>;
  using Ended = typename Setting::Ended;
  const Set set(t.walk);
  const bool absorbs = C == 0 && t.walk.ends_absorb && t.batch_count == 1;
  const Setting s{t,       set,
                  score,   {Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])},
                  absorbs, first_lanes<float>(absorbs ? 0 : kLanes)};
  typename Setting::Pool pool;
  Ended ended;
  LoopTotals totals;
  LaneWalks<C> all[kSets];
  for (LaneWalks<C>& w : all) empty(w, s.incident);

  pool.fill(t, set);
  if constexpr (Set::kSingle) lockstep(s, pool, all, ended, totals);
  for (;;) {
    const int walking = take_walks(s, pool, all);
    if (walking == 0) break;
    if (walking <= kLanes && walking > kLanes - all[0].free_count) crowd(all);
    if constexpr (Set::kSingle)
      set_by_set(s, all, ended, totals);
    else
      by_turns(s, all, ended, totals);
    if (ended.size >= Ended::kSize) ended.count_all(t);
  }
  LaneSums& sums = close(s, ended, totals);
  if (absorbs)
    sums.ends[Ended::place(WalkEnd::absorbed, kRouletteOrder)] +=
        pool.beginnings.collided - ended.told;
  sums.events += kRefuses<Set> ? totals.events : totals.carried;
}

}  // namespace lamella::LAMELLA_ISA
