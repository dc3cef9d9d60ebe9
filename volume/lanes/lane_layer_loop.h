#pragma once

// Many walks on lanes through a stack, layer by layer: all lanes walk in one layer, whose medium is
// known at compile time, while those of the other layers wait in stores. Only for sources of
// lamella_lanes().

#include <memory>

#include "volume/lanes/lane_loop.h"
#include "volume/lanes/lane_stored_walks.h"

namespace lamella::LAMELLA_ISA {

/// The loop. It takes turns in the layers: a turn lasts until the layer has too few walks left to
/// fill the lanes.
template <int C, class Score>
struct LayeredWalks {
  using Set = AnyMedia<Floats>;
  using Setting = LoopSetting<C, Set, Score>;
  using State = LaneState<Floats, C>;
  using Walks = LaneWalks<C, State>;
  static constexpr int kInLanes = kSets * kLanes;
  /// Walks under way, so that turns are long; all of them have room in every store.
  static constexpr int kMost = 16 * kInLanes;
  using Store = StoredWalks<C, State, kMost, false, Score::kUsesIndex>;

  /// Walks of a layer that no lane has.
  struct Waiting {
    Store colliding;  ///< at their next event
    Store arriving;   ///< at the layer's edge; y: mean free paths left of their flight
    [[nodiscard]] int count() const { return colliding.size + arriving.size; }
  };

  const Setting& s;
  LaneBeginnings<C, Set> beginnings;
  typename Setting::Ended ended;
  LoopTotals totals;
  int layer_count;  // and the substrate
  Waiting* layers;  // the substrate behind them
  int under_way = 0, most;
  bool all_begun = false;
  const bool forced;  // all walks collide; else turns in the layer `entry` begin walks
  const int entry;
  Walks all[kSets];

  /// Memory for the stores of a thread, which all of its tasks share: touching it for the first
  /// time takes longer than many a task.
  static Waiting* waiting_of(int layers) {
    thread_local std::unique_ptr<Waiting[]> memory;
    thread_local int size = 0;
    if (layers > size) memory = std::make_unique_for_overwrite<Waiting[]>(layers);
    size = std::max(size, layers);
    return memory.get();
  }
  explicit LayeredWalks(const Setting& setting)
      : s(setting),
        layer_count(s.task.walk.layer_count + (s.task.walk.substrate ? 1 : 0)),
        layers(waiting_of(layer_count)),
        forced(s.task.walk.forced_chance > 0),
        entry(s.task.walk.from_above ? 0 : s.task.walk.layer_count - 1) {
    const LatticeNumbers* lattice = s.task.walk.lattice;
    for (int k = 0; k < layer_count; ++k)
      for (Store* store : {&layers[k].colliding, &layers[k].arriving}) {
        store->size = 0;
        store->has_point = lattice != nullptr;
        store->has_shift = lattice != nullptr && lattice->by_walk;
      }
    most = std::min<int>(kMost, layer_count * 4 * kInLanes);
    for (Walks& walks : all) empty(walks, s.incident);
  }

  /// First flights within the layer that light enters, which tell where walks are afterwards.
  template <class One>
  struct FirstFlights {
    static constexpr bool kBounded = false;
    const One& one;
    Floats depth;
    FloatMask& inside;
    /// Every walk is to be sent on.
    LAMELLA_INLINE FloatMask fly(Vec3<Floats> wi, Floats remaining, FloatMask exist, Words&,
                                 Floats& y) const {
      inside = exist & fly_within(one, wi, remaining, depth, y);
      return exist;
    }
  };

  /// Begins walks in the layer that light enters, while there is room for them.
  template <class One>
  LAMELLA_INLINE void begin_in(const One& one, int layer, Floats depth) {
    const LaneWalkTask& t = s.task;
    const LaneNumbers blocks(t);
    Waiting& here = layers[layer];
    while (under_way + kLanes <= most) {
      State w;
      FloatMask walks, inside;
      const FirstFlights<One> flights{one, depth, inside};
      const int begun = beginnings.begin_some(t, flights, blocks, w, walks);
      all_begun = begun == 0;
      if (all_begun) break;
      under_way += begun;
      here.colliding.push(w, inside);
      const FloatMask leaves = without(walks, inside), down = leaves & (w.wi.z > Floats(0));
      const FloatMask ends = send_on(w, layer, without(leaves, down), down);
      if (any(ends)) end(w, ends, without(ends, ends));
    }
  }

  /// The same for walks that all collide, in whichever layer.
  [[gnu::noinline]] void begin_forced() {
    const LaneWalkTask& t = s.task;
    const LaneNumbers blocks(t);
    while (under_way + kLanes <= most) {
      State w;
      FloatMask walks;
      const int begun = beginnings.begin_some(t, s.set, blocks, w, walks);
      all_begun = begun == 0;
      if (all_begun) break;
      under_way += begun;
      for (int k = 0; k < layer_count; ++k)
        layers[k].colliding.push(
            w, walks & to_float_mask(equal(w.layer, Words(static_cast<std::uint32_t>(k)))));
    }
  }

  /// Ends the lanes `ends`, `gone` of them by an event.
  LAMELLA_INLINE void end(State& w, FloatMask ends, FloatMask gone) {
    using Ended = typename Setting::Ended;
    totals.poison = multiply_add(select(ends, w.wi.z, Floats(0)), Floats(0), totals.poison);
    FloatMask tells = ends;
    if constexpr (C == 0) tells = without(ends, without(gone, s.tells_gone));
    Words events = shift_left<Ended::kBits>(w.order);
    events = select(to_word_mask(gone), events | Words(1u), events);
    if constexpr (C > 0) events = select(is_below(w.order, w.death), events, events | Words(2u));
    note_ends<C>(s, w, tells, events, ended);
    const int fallen = lamella::LAMELLA_ISA::count(ends);
    under_way -= fallen;
    ended.size += C == 0 ? lamella::LAMELLA_ISA::count(tells) : fallen;
    if (ended.size >= Setting::Ended::kSize) ended.count_all(s.task);
  }

  /// Sends walks with y mean free paths left out of a layer, up and down: to the next one, or to
  /// their ends. Which of them end so.
  LAMELLA_INLINE FloatMask send_on(const State& w, int layer, FloatMask up, FloatMask down) {
    FloatMask ends = without(up, up);
    const int last = layer_count - 1;
    if (layer == 0)
      ends = up;
    else if (any(up))
      layers[layer - 1].arriving.push(w, up);
    if (layer == last)
      ends = ends | down;
    else if (any(down)) {
      Waiting& below = layers[layer + 1];
      (layer + 1 == s.task.walk.layer_count ? below.colliding : below.arriving).push(w, down);
    }
    return ends;
  }

  /// A flight within a layer; which lanes are still in it. Those that leave get the mean free paths
  /// that remain in the place of y.
  template <class One>
  LAMELLA_INLINE static FloatMask fly_within(const One& one, Vec3<Floats> wi, Floats remaining,
                                             Floats depth, Floats& y) {
    using std::abs;
    if constexpr (One::kSubstrate) {
      y = remaining;
      return first_lanes<float>(0);
    } else {
      const Floats inverse = one.medium.inverse_area(wi);
      const FloatMask down = wi.z > Floats(0);
      const Floats to = multiply_add(remaining * inverse, wi.z, y);
      const FloatMask inside = (down & (to < depth)) | without(to > Floats(0), down);
      const Floats way = select(down, depth - y, y);
      // Of a half space that is left downwards nothing remains to be crossed.
      const Floats spent = min(way * reciprocal(max(abs(wi.z), Floats(1e-30f))), Floats(1e30f)) *
                           reciprocal(inverse);
      y = select(inside, to, nonnegative(remaining - spent));
      return inside;
    }
  }

  /// Flights of walks that arrive in a layer.
  template <class One>
  LAMELLA_INLINE void let_in(const One& one, int layer, Floats depth) {
    Waiting& here = layers[layer];
    const FloatMask every = first_lanes<float>(kLanes);
    State w;
    while (here.colliding.size < kInLanes && here.arriving.size > 0) {
      const FloatMask lanes = here.arriving.pop(w, every);
      const Floats remaining = w.y;
      w.y = select(w.wi.z > Floats(0), Floats(0), depth);
      const FloatMask inside = lanes & fly_within(one, w.wi, remaining, depth, w.y);
      here.colliding.push(w, inside);
      const FloatMask leaves = without(lanes, inside), down = leaves & (w.wi.z > Floats(0));
      const FloatMask ends = send_on(w, layer, without(leaves, down), down);
      if (any(ends)) end(w, ends, without(ends, ends));
    }
  }

  /// Gives walks of a layer to free lanes; how many are on their way then.
  LAMELLA_INLINE int take(Store& colliding) {
    int walking = 0;
    for (Walks& walks : all) {
      if (walks.free_count > 0 && colliding.size > 0) {
        const FloatMask taken = colliding.pop(walks.state, walks.free);
        walks.free = without(walks.free, taken);
        walks.free_count -= lamella::LAMELLA_ISA::count(taken);
      }
      walking += kLanes - walks.free_count;
    }
    return walking;
  }

  /// Frees all lanes.
  LAMELLA_INLINE void put_back(Store& colliding) {
    for (Walks& walks : all) {
      if (walks.free_count < kLanes) colliding.push(walks.state, !walks.free);
      walks.free = first_lanes<float>(kLanes);
      walks.free_count = kLanes;
    }
  }

  /// A turn in a layer.
  template <template <class> class M>
  [[gnu::noinline]] void take_turn(int layer) {
    using One = OneOfLayers<Floats, M>;
    const LaneWalkTask& t = s.task;
    const One one(t.walk, layer);
    const Floats depth(One::kSubstrate ? 0.0f : t.walk.layers->value[kDepth][layer]);
    Waiting& here = layers[layer];
    const Words at(static_cast<std::uint32_t>(layer));
    for (Walks& walks : all) walks.state.layer = at;
    int least = 0;
    for (bool first = true;; first = false) {
      if constexpr (!One::kSubstrate) {
        if (here.colliding.size < kInLanes) let_in(one, layer, depth);
        if (here.colliding.size < kInLanes && !forced && !all_begun && layer == entry)
          begin_in(one, layer, depth);
      }
      const int walking = take(here.colliding);
      if (walking == 0) break;
      const bool others = walking + here.count() < under_way || !all_begun;
      if (first) least = std::min(kInLanes, walking + here.count()) * 3 / 4;
      if (!first && others && walking < least) break;
      if (walking <= kLanes && walking > kLanes - all[0].free_count) {
        // The last ones: a step costs as much for one of them as for all of a set.
        put_back(here.colliding);
        take(here.colliding);
      }
      LaneDraws<Floats> draws[kSets];
      LaneEnds<Floats> now[kSets];
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k)
        if (all[k].free_count < kLanes) draw(t.walk, one, all[k].state, draws[k]);
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k)
        if (all[k].free_count < kLanes)
          now[k] = scatter<C>(t.walk, one, all[k].state, draws[k], !all[k].free, s.score);
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k) {
        Walks& walks = all[k];
        if (walks.free_count == kLanes) continue;
        State& w = walks.state;
        const FloatMask active = !walks.free, lives = active & now[k].lives;
        const FloatMask inside = lives & fly_within(one, w.wi, draws[k].remaining, depth, w.y);
        const FloatMask leaves = without(lives, inside), down = leaves & (w.wi.z > Floats(0));
        const FloatMask gone = without(active, lives);
        const FloatMask ends = gone | send_on(w, layer, without(leaves, down), down);
        end(w, ends, gone);
        totals.carried += static_cast<std::uint64_t>(kLanes - walks.free_count);
        if constexpr (One::kSubstrate)
          totals.reflections +=
              static_cast<std::uint64_t>(lamella::LAMELLA_ISA::count(now[k].reflections));
        ++totals.steps;
        walks.free = !inside;
        walks.free_count = kLanes - lamella::LAMELLA_ISA::count(inside);
      }
    }
    put_back(here.colliding);
  }

  void take_turn_in(int layer) {
    const WalkSetting<float>& t = s.task.walk;
    with_lane_medium(t, layer, [&]<template <class> class M>() { take_turn<M>(layer); });
  }

  void run() {
    while (!all_begun || under_way > 0) {
      if (forced && !all_begun) begin_forced();
      int fullest = 0;
      for (int k = 1; k < layer_count; ++k)
        if (layers[k].count() > layers[fullest].count()) fullest = k;
      // Room for half of them is room for new ones.
      if (!forced && !all_begun && under_way < most / 2) fullest = entry;
      take_turn_in(fullest);
    }
    LaneSums& sums = close(s, ended, totals);
    if (s.absorbs)
      sums.ends[Setting::Ended::place(WalkEnd::absorbed, kRouletteOrder)] +=
          beginnings.collided - ended.told;
    sums.events += totals.carried;
  }
};

/// The walks of a task, layer by layer.
template <int C, class Score>
[[gnu::noinline]] void layered_walks_of(const LaneWalkTask& t, const Score& score) {
  const AnyMedia<Floats> set(t.walk);
  const bool absorbs = C == 0 && t.walk.ends_absorb && t.batch_count == 1;
  const LoopSetting<C, AnyMedia<Floats>, Score> s{
      t,       set,
      score,   {Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])},
      absorbs, first_lanes<float>(absorbs ? 0 : kLanes)};
  LayeredWalks<C, Score>(s).run();
}

}  // namespace lamella::LAMELLA_ISA
