#pragma once

// Many walks on lanes: a lane takes the next walk as soon as its own has ended. Only for sources of
// lamella_lanes().

#include "phase/lane_math.h"
#include "phase/lane_random.h"
#include "volume/lane_walk.h"

namespace lamella::LAMELLA_ISA {

inline constexpr int kLanes = Floats::kCount;

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

/// Walks that are about to have their first collision, made many at once, for lanes that fall free.
template <int C, class Set, class Score>
struct LanePool {
  static constexpr int kSize = 256;
  static constexpr bool kDeath = C == 0, kLayer = !Set::kSingle, kIndex = Score::kUsesIndex;
  int from = 0, to = 0;
  std::uint32_t made = 0;  // walks begun so far
  std::uint64_t uncollided = 0;
  alignas(64) std::uint32_t numbers[4][kSize + 2 * kLanes];
  alignas(64) std::uint32_t index[kSize + 2 * kLanes];
  alignas(64) std::uint32_t death[kSize + 2 * kLanes];
  alignas(64) std::uint32_t layer[kSize + 2 * kLanes];
  alignas(64) float y[kSize + 2 * kLanes];

  // Fills up to kSize, until the walks of the task are used up.
  [[gnu::noinline]] void fill(const LaneWalkTask& t, const Set& set) {
    const int left = to - from;
    for (int k = 0; k < left; k += kLanes) {
      for (auto& word : numbers) Words::load(word + from + k).store(word + k);
      if constexpr (kIndex) Words::load(index + from + k).store(index + k);
      if constexpr (kDeath) Words::load(death + from + k).store(death + k);
      if constexpr (kLayer) Words::load(layer + from + k).store(layer + k);
      Floats::load(y + from + k).store(y + k);
    }
    from = 0;
    to = left;
    const LaneNumbers blocks(t);
    while (to < kSize && made < t.walks) {
      const std::uint32_t rest = t.walks - made;
      const int n = rest < static_cast<std::uint32_t>(kLanes) ? static_cast<int>(rest) : kLanes;
      LaneState<Floats, C> w;
      const Words place = Words(made) + Words::iota();
      w.index = Words(t.index_low) + Words(hn::Mul(place.v, Words(t.index_stride).v));
      w.numbers = WalkNumbers<Words>(blocks(Words(0u), kLaneWalkStream, w.index));
      const FloatMask hits = begin<C>(t.walk, set, w, first_lanes<float>(n));
      const int found = count(hits);
      uncollided += static_cast<std::uint64_t>(n - found);
      for (int k = 0; k < 4; ++k) store_compressed(w.numbers.s[k], hits, numbers[k] + to);
      if constexpr (kIndex) store_compressed(w.index, hits, index + to);
      if constexpr (kDeath) store_compressed(w.death, hits, death + to);
      if constexpr (kLayer) store_compressed(w.layer, hits, layer + to);
      store_compressed(w.y, hits, y + to);
      to += found;
      made += static_cast<std::uint32_t>(n);
    }
  }
};

/// Walks that ended, until there are enough of them to count them at a stretch.
template <int C>
struct EndedWalks {
  static constexpr int kSize = 512, kPlaces = kWalkEnds * static_cast<int>(kRouletteOrder + 1);
  int size = 0;
  alignas(64) std::uint32_t code[kSize + 2 * kLanes];
  alignas(64) float x[kSize + 2 * kLanes];  // w_i of the last flight
  alignas(64) float y[kSize + 2 * kLanes];
  alignas(64) float z[kSize + 2 * kLanes];
  alignas(64) float weight[C > 0 ? C : 1][kSize + 2 * kLanes];
  bool finite = true;
  // Per lane, so that no counter waits for itself.
  std::uint32_t counted[kPlaces][kLanes] = {};

  [[gnu::noinline]] void count_all(const LaneWalkTask& t, LaneSums& sums) {
    const bool cells = t.estimate == LaneEstimate::cells_counted;
    const int targets = t.cells.rows * t.cells.columns * (t.cells.both_sides ? 2 : 1);
    const int nowhere = 4 * targets;
    alignas(64) std::uint32_t place[kLanes], target[kLanes], orders[kLanes];
    for (int k = 0; k < size; k += kLanes) {
      const int n = size - k < kLanes ? size - k : kLanes;
      const LaneEnd<Words> of(Words::load(code + k), t.walk.max_order);
      const Words at = of.end * Words(kRouletteOrder + 1) + min(of.order, Words(kRouletteOrder));
      at.store(place);
      if (cells) {
        targets_of(t, k, of, Words(nowhere) + at).store(target);
        const Floats flat = Floats::load(x + k) + Floats::load(y + k);
        finite = finite && !any(!equal(flat * Floats(0), Floats(0)) & first_lanes<float>(n));
        if (!t.weighs()) {  // a walk in a cell is counted nowhere else
          for (int j = 0; j < n; ++j) ++sums.cells[target[j]];
          continue;
        }
      }
      for (int j = 0; j < n; ++j) ++counted[place[j]][j];
      if (!t.weighs()) continue;
      min(of.order, Words(t.order_cap)).store(orders);
      for (int channel = 0; channel < t.channels; ++channel) {
        std::int64_t* weights = sums.weights + channel * kPlaces;
        const int first_cell = channel * nowhere;
        for (int j = 0; j < n; ++j) {
          const std::int64_t w =
              C > 0 ? static_cast<std::int64_t>(weight[C > 0 ? channel : 0][k + j] * 0x1p32f)
                    : t.end_weight[static_cast<std::uint32_t>(channel) * (t.order_cap + 1) +
                                   orders[j]];
          weights[place[j]] += w;
          if (cells && target[j] < static_cast<std::uint32_t>(nowhere))
            sums.cells[first_cell + static_cast<int>(target[j])] += w;
        }
      }
    }
    size = 0;
  }

  void add_counts(LaneSums& sums) const {
    for (int place = 0; place < kPlaces; ++place)
      for (const std::uint32_t n : counted[place]) sums.ends[place] += n;
  }

 private:
  // [slot][target], or `elsewhere`.
  LAMELLA_INLINE Words targets_of(const LaneWalkTask& t, int k, const LaneEnd<Words>& of,
                                  Words elsewhere) const {
    const Floats wz = Floats::load(z + k);
    // w_o = -w_i: half a turn further than w_i.
    Floats turns =
        turns_of(Floats::load(y + k), Floats::load(x + k)) + Floats(0.5f - t.cells.azimuth_turns);
    turns = turns - floor(turns);
    if (t.cells.folded) turns = min(turns, Floats(1) - turns);
    const Floats row =
        min(nonnegative((Floats(1) - wz * wz) * Floats(t.cells.rows)), Floats(t.cells.rows - 0.5f));
    const Floats column = min(turns * Floats(t.cells.phi_cells), Floats(t.cells.columns - 0.5f));
    const WordMask down = equal(of.end, Words(static_cast<std::uint32_t>(WalkEnd::down)));
    const WordMask left =
        (of.order > Words(0u)) &
        (of.end <
         Words(static_cast<std::uint32_t>(t.cells.both_sides ? WalkEnd::absorbed : WalkEnd::down)));
    const int cells = t.cells.rows * t.cells.columns;
    const Words below = select(down, Words(cells), Words(0u));
    const Words slot = max(min(of.order, Words(kRouletteOrder)), Words(1u)) - Words(1u);
    const Words target = to_words(row) * Words(t.cells.columns) + to_words(column) + below +
                         slot * Words(t.cells.both_sides ? 2 * cells : cells);
    return select(left, target, elsewhere);
  }
};

/// The walks of a task. The numbers of a walk are those of (seed, walk), so that it does not matter
/// when and where it happens.
template <int C, class Set, class Score>
[[gnu::noinline]] void walks_of(const LaneWalkTask& t, LaneSums& sums, const Score& score) {
  const Set set(t.walk);
  const Vec3<Floats> incident{Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])};
  LanePool<C, Set, Score> pool;
  EndedWalks<C> ended;
  std::uint64_t steps = 0, busy = 0, reflected = 0;
  // 0, or not a number from the first such direction on: what is wrong with x or y is at the next
  // event wrong with z, and at the last one count_all sees it. Depths follow: they are never 0
  // times infinity, as 1 / sigma and lengths of flights are finite.
  Floats poison(0);
  // Two sets of lanes that know nothing of each other: while one waits for its numbers, the other's
  // are computed.
  constexpr int kSets = 2;
  struct Walks {
    LaneState<Floats, C> state;
    FloatMask active;
  };
  Walks all[kSets];
  for (Walks& w : all) {
    w.state.wi = incident;
    w.state.y = Floats(0);
    w.state.layer = w.state.order = w.state.index = Words(0u);
    w.state.numbers.s[0] = w.state.numbers.s[1] = Words(0u);
    w.state.numbers.s[2] = w.state.numbers.s[3] = Words(0u);
    w.state.death = Words(1u);
    for (Floats& weight : w.state.weight) weight = Floats(1);
    w.active = first_lanes<float>(0);
  }
  pool.fill(t, set);

  const auto refill = [&](Walks& walks) LAMELLA_INLINE_LAMBDA {
    LaneState<Floats, C>& w = walks.state;
    const int available = pool.to - pool.from;
    FloatMask take = !walks.active;
    const Words rank = rank_of(take);
    if (available < kLanes)
      take = take & to_float_mask(rank < Words(static_cast<std::uint32_t>(available)));
    const WordMask words = to_word_mask(take);
    const auto word = [&](const std::uint32_t* from, Words old) LAMELLA_INLINE_LAMBDA {
      return select(words, permute(Words::load(from + pool.from), rank), old);
    };
    for (int k = 0; k < 4; ++k) w.numbers.s[k] = word(pool.numbers[k], w.numbers.s[k]);
    if constexpr (pool.kIndex) w.index = word(pool.index, w.index);
    if constexpr (pool.kDeath) w.death = word(pool.death, w.death);
    if constexpr (pool.kLayer) w.layer = word(pool.layer, w.layer);
    w.y = select(take, permute(Floats::load(pool.y + pool.from), rank), w.y);
    w.order = select(words, Words(0u), w.order);
    if constexpr (C > 0)
      for (Floats& weight : w.weight) weight = select(take, Floats(1), weight);
    w.wi = select(take, incident, w.wi);
    walks.active = walks.active | take;
    pool.from += count(take);
    if (pool.to - pool.from < kLanes) pool.fill(t, set);
  };

  const auto advance = [&](Walks& walks) LAMELLA_INLINE_LAMBDA {
    LaneState<Floats, C>& w = walks.state;
    const auto [ends, code, events, reflections] = step<C>(t.walk, set, w, walks.active, score);
    poison = multiply_add(w.wi.z, Floats(0), poison);
    store_compressed(code, ends, ended.code + ended.size);
    if (t.estimate == LaneEstimate::cells_counted) {
      store_compressed(w.wi.x, ends, ended.x + ended.size);
      store_compressed(w.wi.y, ends, ended.y + ended.size);
      store_compressed(w.wi.z, ends, ended.z + ended.size);
    }
    if constexpr (C > 0)
      for (int c = 0; c < C; ++c) store_compressed(w.weight[c], ends, ended.weight[c] + ended.size);
    ended.size += count(ends);
    if (ended.size >= EndedWalks<C>::kSize) ended.count_all(t, sums);
    walks.active = without(walks.active, ends);
    busy += static_cast<std::uint64_t>(count(events));
    if constexpr (!Set::kSingle) reflected += static_cast<std::uint64_t>(count(reflections));
  };

  for (;;) {
    FloatMask active = first_lanes<float>(0);
    for (Walks& w : all) {
      refill(w);
      active = active | w.active;
    }
    if (!any(active)) break;
    for (Walks& w : all) advance(w);
    steps += kSets;
  }
  ended.count_all(t, sums);
  ended.add_counts(sums);
  score.finish();
  const auto straight = static_cast<int>(t.walk.from_above ? WalkEnd::down : WalkEnd::up);
  const int place = straight * static_cast<int>(kRouletteOrder + 1);
  sums.ends[place] += pool.uncollided;
  for (int c = 0; t.weighs() && c < t.channels; ++c)
    sums.weights[c * kWalkEnds * static_cast<int>(kRouletteOrder + 1) + place] +=
        static_cast<std::int64_t>(pool.uncollided << 32);
  sums.lane_steps += steps * static_cast<std::uint64_t>(kLanes);
  sums.busy_lane_steps += busy;
  sums.reflections += reflected;
  sums.finite = sums.finite && ended.finite && !any(!equal(poison, Floats(0)));
}

}  // namespace lamella::LAMELLA_ISA
