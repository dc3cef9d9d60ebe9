#pragma once

// Walks that begin, and those that lanes are to take. Only for sources of lamella_lanes().

#include "phase/lanes/lane_math.h"
#include "phase/random/lane_random.h"
#include "volume/lanes/lane_task.h"

namespace lamella::LAMELLA_ISA {

inline constexpr int kLanes = Floats::kCount;
/// Sets of lanes that know nothing of each other and step together: while one waits for its
/// numbers, those of the others are computed.
inline constexpr int kSets = 4;

/// Blocks of random words of walks whose indices share their upper half.
struct LaneNumbers {
  std::uint32_t key0, key1;
  Words index_high;
  LAMELLA_INLINE explicit LaneNumbers(const LaneWalkTask& t)
      : key0(static_cast<std::uint32_t>(t.walk.seed)),
        key1(static_cast<std::uint32_t>(t.walk.seed >> 32)),
        index_high(t.index_high) {}
  LAMELLA_INLINE WordBlock operator()(Words position, std::uint32_t stream, Words index) const {
    return philox(position, Words(stream), index, index_high, key0, key1);
  }
};

/// Begins the walks of a task, up to their first collisions.
template <int C, class Set>
struct LaneBeginnings {
  std::uint32_t batch = 0, made = 0;  // the batch under way; how many of its walks have begun
  std::uint64_t uncollided = 0;       // among them
  std::uint64_t collided = 0;         // of all batches

  /// The next walks, one per lane: how many of them there are, 0 where none is left, and which
  /// collide.
  template <class Flights>
  LAMELLA_INLINE int begin_some(const LaneWalkTask& t, const Flights& set,
                                const LaneNumbers& blocks, LaneState<Floats, C>& w,
                                FloatMask& hits) {
    while (batch < t.batch_count && t.batches[batch].walks == made) end_batch(t);
    if (batch == t.batch_count) return 0;
    const LaneBatch& here = t.batches[batch];
    const std::uint32_t rest = here.walks - made;
    const int n = rest < static_cast<std::uint32_t>(kLanes) ? static_cast<int>(rest) : kLanes;
    const Words ramp(hn::Mul(Words::iota().v, Words(t.index_stride).v));
    w.index = Words(here.index_low + made * t.index_stride) + ramp;
    w.numbers = WalkNumbers<Words>(blocks(Words(0u), kLaneWalkStream, w.index));
    if (t.walk.lattice != nullptr) {
      w.point = reversed_bits(Words(here.point + made) + Words::iota());
      w.shift = Words(here.shift);
    }
    Vec3<Floats> light{Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])};
    if (t.incident_law != IncidentLaw::fixed) light = drawn_light(t, w.numbers);
    hits = begin_from<C>(light, t.walk, set, w, first_lanes<float>(n));
    if (t.estimate == LaneEstimate::walk_by_walk) record(t, light, hits);
    const int found = count(hits);
    uncollided += static_cast<std::uint64_t>(n - found);
    collided += static_cast<std::uint64_t>(found);
    made += static_cast<std::uint32_t>(n);
    return n;
  }

 private:
  LAMELLA_INLINE static Vec3<Floats> drawn_light(const LaneWalkTask& t,
                                                 WalkNumbers<Words>& numbers) {
    const Floats u = fine_uniform_of(numbers.next());
    const auto phi = azimuth_of(numbers.next());
    const Floats mu = t.incident_law == IncidentLaw::uniform ? u : sqrt(u);
    const Floats s = sqrt(nonnegative((Floats(1) - mu) * (Floats(1) + mu)));
    return {s * phi.cosine, s * phi.sine, mu};
  }
  // The next walks as such that go straight through, or end within the stack: of others the end is
  // told later.
  LAMELLA_INLINE void record(const LaneWalkTask& t, Vec3<Floats> light, FloatMask hits) const {
    const int straight = straight_row<Set::kBounded>(t.walk.from_above);
    select(to_word_mask(hits), Words(0u), Words(static_cast<std::uint32_t>(straight + 1)))
        .store(t.records.end + made);
    Words(0u).store(t.records.events + made);
    light.x.store(t.records.x + made);
    light.y.store(t.records.y + made);
    light.z.store(t.records.z + made);
    if (t.incident_law == IncidentLaw::fixed) return;
    light.x.store(t.records.wi_x + made);
    light.y.store(t.records.wi_y + made);
    light.z.store(t.records.wi_z + made);
  }
  void end_batch(const LaneWalkTask& t) {
    LaneSums& sums = *t.batches[batch].sums;
    const int straight = straight_row<Set::kBounded>(t.walk.from_above);
    constexpr int kOrders = static_cast<int>(kRouletteOrder + 1);
    sums.ends[straight * kOrders] += uncollided;
    for (int c = 0; t.weighs() && c < t.channels; ++c)
      sums.weights[(c * kEndRows<Set::kBounded> + straight) * kOrders] +=
          static_cast<std::int64_t>(uncollided << 32);
    ++batch;
    made = 0;
    uncollided = 0;
  }
};

/// Walks that are about to have their first collision, made many at once, for lanes that fall free.
template <int C, class Set, class Score>
struct LanePool {
  static constexpr int kSize = 256, kRoom = kSize + 2 * kLanes;
  static constexpr bool kLayer = !Set::kSingle, kIndex = Score::kUsesIndex;
  int from = 0, to = 0;
  LaneBeginnings<C, Set> beginnings;
  alignas(64) std::uint32_t numbers[4][kRoom];
  alignas(64) std::uint32_t index[kRoom];
  alignas(64) std::uint32_t death[kRoom];
  alignas(64) std::uint32_t layer[kRoom];
  bool lattice = false;
  std::uint32_t first_step = 0;  // of the walks in lanes
  alignas(64) std::uint32_t point[kRoom];
  alignas(64) std::uint32_t shift[kRoom];
  alignas(64) float y[kRoom];
  bool directed = false;  // wi is kept whatever the law of the light
  bool draws = false;     // every walk its w_i
  alignas(64) float wi[3][kRoom];

  // Fills up to kSize, until the walks of the task are used up.
  [[gnu::noinline]] void fill(const LaneWalkTask& t, const Set& set) {
    const int left = to - from;
    draws = t.incident_law != IncidentLaw::fixed || directed;
    lattice = t.walk.lattice != nullptr;
    for (int k = 0; k < left; k += kLanes) {
      for (auto& word : numbers) Words::load(word + from + k).store(word + k);
      if constexpr (kIndex) Words::load(index + from + k).store(index + k);
      Words::load(death + from + k).store(death + k);
      if constexpr (kLayer) Words::load(layer + from + k).store(layer + k);
      Floats::load(y + from + k).store(y + k);
      if (lattice) {
        Words::load(point + from + k).store(point + k);
        Words::load(shift + from + k).store(shift + k);
      }
      for (int axis = 0; draws && axis < 3; ++axis)
        Floats::load(wi[axis] + from + k).store(wi[axis] + k);
    }
    from = 0;
    to = left;
    const LaneNumbers blocks(t);
    while (to < kSize) {
      LaneState<Floats, C> w;
      FloatMask hits;
      if (beginnings.begin_some(t, set, blocks, w, hits) == 0) break;
      const int found = count(hits);
      if (t.walk.collides_at_once &&
          found == kLanes)  // else the branch would cost more than it saves
        keep(w, [](const auto& lanes, auto* at) LAMELLA_INLINE_LAMBDA { lanes.store(at); });
      else
        keep(w, [&](const auto& lanes, auto* at)
                    LAMELLA_INLINE_LAMBDA { store_compressed(lanes, hits, at); });
      to += found;
    }
  }

 private:
  // Behind those that are there; store(lanes, where).
  template <class Store>
  LAMELLA_INLINE void keep(const LaneState<Floats, C>& w, const Store& store) {
    for (int k = 0; k < 4; ++k) store(w.numbers.s[k], numbers[k] + to);
    if constexpr (kIndex) store(w.index, index + to);
    store(w.death, death + to);
    if constexpr (kLayer) store(w.layer, layer + to);
    store(w.y, y + to);
    if (lattice) {
      store(w.point, point + to);
      store(w.shift, shift + to);
    }
    if (!draws) return;
    store(w.wi.x, wi[0] + to);
    store(w.wi.y, wi[1] + to);
    store(w.wi.z, wi[2] + to);
  }
};

}  // namespace lamella::LAMELLA_ISA
