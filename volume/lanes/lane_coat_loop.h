#pragma once

// Walks on lanes below one interface that lies on a substrate, with nothing between. A walk that
// the interface has let in goes to and fro between both: an event at the substrate and the meeting
// with the interface from below are one step, which all lanes take. Only for sources of
// lamella_lanes().

#include "volume/lanes/lane_bounded_loop.h"

namespace lamella::LAMELLA_ISA {

/// The substrate as the only thing that scatters.
struct SubstrateAlone {
  static constexpr bool kSingle = false, kCountsSteps = true;
  const WalkSetting<float>& t;
  LAMELLA_INLINE int words() const { return t.words; }
  template <class F>
  LAMELLA_INLINE void visit(Words layer, const F& f) const {
    f(SubstrateOnLanes<Floats>(LayerPerLane<Floats>{*t.layers, layer}),
      LanesAgree<false>{t.layer_count}, every_lane<Floats>());
  }
};

/// Kind: of the interface, as meet() has it, for light from one side.
template <template <InterfaceSide> class Kind, class Set>
struct CoatedWalks {
  using Setting = LoopSetting<0, Set, NoScore>;
  using Walks = BoundedWalks<0>;
  const Setting& s;
  typename Setting::Ended ended;
  LoopTotals totals;
  std::uint64_t meetings = 0;

  /// Walks that the interface has let in.
  struct Pool : Setting::Pool {
    CoatedWalks& walks;
    explicit Pool(CoatedWalks& owner) : walks(owner) {
      this->directed = true;
      this->first_step = 1;  // the entry is one
    }
    void fill(const LaneWalkTask& t, const Set& set) {
      const int left = this->to - this->from;
      Setting::Pool::fill(t, set);
      walks.enter(*this, left);
    }
  };

  /// Light of the walks at the places from `first` on meets the interface; those that are let in
  /// close up.
  [[gnu::noinline]] void enter(Pool& pool, int first) {
    int inside = first;
    for (int k = first; k < pool.to; k += kLanes) {
      const int n = pool.to - k < kLanes ? pool.to - k : kLanes;
      Walks packet;
      BoundedState<Floats, 0>& w = packet.state;
      packet.free = !first_lanes<float>(n);
      packet.free_count = kLanes - n;
      for (int j = 0; j < 4; ++j) w.numbers.s[j] = Words::load(pool.numbers[j] + k);
      w.death = Words::load(pool.death + k);
      w.wi = {Floats::load(pool.wi[0] + k), Floats::load(pool.wi[1] + k),
              Floats::load(pool.wi[2] + k)};
      w.order = w.index = w.step = Words(0u);
      if (pool.lattice) {
        w.point = Words::load(pool.point + k);
        w.shift = Words::load(pool.shift + k);
      }
      const FloatMask lanes = first_lanes<float>(n);
      const FloatMask stays = meet_interface<InterfaceSide::above>(packet, lanes, lanes);
      for (int j = 0; j < 4; ++j) store_compressed(w.numbers.s[j], stays, pool.numbers[j] + inside);
      store_compressed(w.death, stays, pool.death + inside);
      if (pool.lattice) {
        store_compressed(w.point, stays, pool.point + inside);
        store_compressed(w.shift, stays, pool.shift + inside);
      }
      store_compressed(w.wi.x, stays, pool.wi[0] + inside);
      store_compressed(w.wi.y, stays, pool.wi[1] + inside);
      store_compressed(w.wi.z, stays, pool.wi[2] + inside);
      inside += count(stays);
      if (ended.size >= Setting::Ended::kSize) ended.count_all(s.task);
    }
    pool.to = inside;
  }

  /// The lanes `lives` of `walks` meet the interface, `lanes` are those with a walk; which of them
  /// stay below. All others are handed over.
  template <InterfaceSide kFrom>
  LAMELLA_INLINE FloatMask meet_interface(Walks& walks, FloatMask lanes, FloatMask lives) {
    BoundedState<Floats, 0>& w = walks.state;
    Words words[Kind<kFrom>::kWords];
    draw_meeting<Floats, 0>(s.task.walk, Kind<kFrom>::kWords, lives, w, words);
    const BoundaryEnds<Floats> now = meet<Kind<kFrom>, Floats, 0>(s.task.walk, w, words, lives);
    w.met = Words(3u);  // one rough boundary since the last event
    Words bits = select(to_word_mask(now.lost), Words(kLostBit), Words(0u));
    bits = select(to_word_mask(lives), bits, Words(1u));
    hand_over<0>(s, walks, without(lanes, now.lives), bits, ended, totals);
    count_step(count(lives), meetings);
    return now.lives;
  }
  LAMELLA_INLINE void count_step(int lanes, std::uint64_t& things) {
    things += static_cast<std::uint64_t>(lanes);
    totals.carried += static_cast<std::uint64_t>(lanes);
    ++totals.steps;
  }

  [[gnu::noinline]] void run() {
    const LaneWalkTask& t = s.task;
    const SubstrateAlone substrate{t.walk};
    Pool pool(*this);
    Walks all[kSets];
    for (Walks& w : all) empty(w, s.incident);
    pool.fill(t, s.set);
    for (;;) {
      const int walking = take_walks(s, pool, all);
      if (walking == 0) break;
      if (walking <= kLanes && walking > kLanes - all[0].free_count) crowd(all);
      LaneDraws<Floats> draws[kSets];
      FloatMask lives[kSets];
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k) draw<0>(t.walk, substrate, all[k].state, draws[k]);
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k) {
        const FloatMask lanes = !all[k].free;
        const LaneEnds<Floats> now =
            scatter<0>(t.walk, substrate, all[k].state, draws[k], lanes, s.score);
        lives[k] = lanes & now.lives;
        totals.reflections += static_cast<std::uint64_t>(count(now.reflections));
      }
      for (int k = 0; k < kSets; ++k) {
        if (all[k].free_count == kLanes) continue;
        count_step(kLanes - all[k].free_count, totals.events);
        meet_interface<InterfaceSide::below>(all[k], !all[k].free, lives[k]);
      }
      if (ended.size >= Setting::Ended::kSize) ended.count_all(t);
    }
    LaneSums& sums = close(s, ended, totals);
    sums.events += totals.events;
    sums.meetings += meetings;
  }
};

/// The walks of a task, if the stack is one interface of this kind on a substrate, and light comes
/// from above; whether it is.
template <template <InterfaceSide> class Kind, class Set>
[[gnu::noinline]] bool coated_walks_of(const LaneWalkTask& t) {
  if (!t.walk.substrate || !t.walk.from_above || t.walk.layer_count != 1 ||
      !Kind<InterfaceSide::any>::describes(*t.walk.boundaries))
    return false;
  const Set set(t.walk);
  const NoScore score{};
  const LoopSetting<0, Set, NoScore> s{
      t,     set,
      score, {Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])},
      false, first_lanes<float>(kLanes)};
  CoatedWalks<Kind, Set>{s, {}, {}}.run();
  return true;
}

}  // namespace lamella::LAMELLA_ISA
