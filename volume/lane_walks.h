#pragma once

// Many walks on lanes: a lane takes the next walk as soon as its own has ended. Only for sources of
// lamella_lanes().

#include "phase/lane_math.h"
#include "phase/lane_random.h"
#include "volume/lane_walk.h"

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

/// Walks that are about to have their first collision, made many at once, for lanes that fall free.
template <int C, class Set, class Score>
struct LanePool {
  static constexpr int kSize = 256, kRoom = kSize + 2 * kLanes;
  static constexpr bool kLayer = !Set::kSingle, kIndex = Score::kUsesIndex;
  int from = 0, to = 0;
  std::uint32_t batch = 0, made = 0;  // of its walks so many have begun
  std::uint64_t uncollided = 0;       // among them
  alignas(64) std::uint32_t numbers[4][kRoom];
  alignas(64) std::uint32_t index[kRoom];
  alignas(64) std::uint32_t death[kRoom];
  alignas(64) std::uint32_t layer[kRoom];
  alignas(64) float y[kRoom];

  // Fills up to kSize, until the walks of the task are used up.
  [[gnu::noinline]] void fill(const LaneWalkTask& t, const Set& set) {
    const int left = to - from;
    for (int k = 0; k < left; k += kLanes) {
      for (auto& word : numbers) Words::load(word + from + k).store(word + k);
      if constexpr (kIndex) Words::load(index + from + k).store(index + k);
      Words::load(death + from + k).store(death + k);
      if constexpr (kLayer) Words::load(layer + from + k).store(layer + k);
      Floats::load(y + from + k).store(y + k);
    }
    from = 0;
    to = left;
    const LaneNumbers blocks(t);
    const Words ramp(hn::Mul(Words::iota().v, Words(t.index_stride).v));
    while (to < kSize && batch < t.batch_count) {
      const LaneBatch& here = t.batches[batch];
      const std::uint32_t rest = here.walks - made;
      if (rest == 0) {
        end_batch(t);
        continue;
      }
      const int n = rest < static_cast<std::uint32_t>(kLanes) ? static_cast<int>(rest) : kLanes;
      LaneState<Floats, C> w;
      w.index = Words(here.index_low + made * t.index_stride) + ramp;
      w.numbers = WalkNumbers<Words>(blocks(Words(0u), kLaneWalkStream, w.index));
      const FloatMask hits = begin<C>(t.walk, set, w, first_lanes<float>(n));
      const int found = count(hits);
      uncollided += static_cast<std::uint64_t>(n - found);
      if (t.walk.collides_at_once &&
          found == kLanes)  // else the branch would cost more than it saves
        keep(w, [](const auto& lanes, auto* at) LAMELLA_INLINE_LAMBDA { lanes.store(at); });
      else
        keep(w, [&](const auto& lanes, auto* at)
                    LAMELLA_INLINE_LAMBDA { store_compressed(lanes, hits, at); });
      to += found;
      made += static_cast<std::uint32_t>(n);
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
  }
  void end_batch(const LaneWalkTask& t) {
    LaneSums& sums = *t.batches[batch].sums;
    const int straight = static_cast<int>(t.walk.from_above ? WalkEnd::down : WalkEnd::up);
    constexpr int kOrders = static_cast<int>(kRouletteOrder + 1);
    sums.ends[straight * kOrders] += uncollided;
    for (int c = 0; t.weighs() && c < t.channels; ++c)
      sums.weights[(c * kWalkEnds + straight) * kOrders] +=
          static_cast<std::int64_t>(uncollided << 32);
    ++batch;
    made = 0;
    uncollided = 0;
  }
};

/// Walks that ended, until there are enough of them to count them at a stretch. kIndex: each in the
/// sums of the batch that its index tells.
template <int C, bool kIndex>
struct EndedWalks {
  static constexpr int kSize = 512, kRoom = kSize + (kSets + 1) * kLanes;
  static constexpr int kPlaces = kWalkEnds * static_cast<int>(kRouletteOrder + 1);
  // Events, and as last bits whether one ended the walk and, of walks with weights, whether that
  // was by thinning or the one too many.
  static constexpr int kBits = C > 0 ? 2 : 1;
  int size = 0;
  alignas(64) std::uint32_t events[kRoom];
  alignas(64) std::uint32_t index[kRoom];
  alignas(64) float x[kRoom];  // w_i of the last flight
  alignas(64) float y[kRoom];
  alignas(64) float z[kRoom];
  alignas(64) float weight[C > 0 ? C : 1][kRoom];
  bool finite = true;
  // Per lane, so that no counter waits for itself.
  std::uint32_t counted[kPlaces][kLanes] = {};

  [[gnu::noinline]] void count_all(const LaneWalkTask& t) {
    const bool thins = t.walk.thinned_from > 0;
    const bool cells = t.estimate == LaneEstimate::cells_counted;
    const bool weighs = t.weighs();
    const int nowhere = 4 * t.cells.rows * t.cells.columns * (t.cells.both_sides ? 2 : 1);
    Floats spoiled(0);  // or not a number
    // What is a vector's work, then what is not, so that nothing waits in between.
    for (int k = 0; k < size; k += kLanes) {
      const Words met = Words::load(events + k);
      const auto bit = [&](std::uint32_t value)
                           LAMELLA_INLINE_LAMBDA { return !equal(met & Words(value), Words(0u)); };
      LaneEnd<Words> of(shift_right<kBits>(met), bit(1),
                        to_word_mask(Floats::load(z + k) > Floats(0)), t.walk.max_order);
      if (thins) {
        const Words spared = spared_of(t.walk.thinned_from, of.order);
        spared.store(spared_of_walk + k);
        // Without weights: thinned or absorbed, at an event that does both.
        WordMask halves = bit(2);
        if constexpr (C == 0)
          halves = !equal(spared, spared_of(t.walk.thinned_from, of.order - Words(1u)));
        const WordMask gone = equal(of.end, Words(static_cast<std::uint32_t>(WalkEnd::absorbed)));
        of.end = select(gone & halves, Words(static_cast<std::uint32_t>(WalkEnd::thinned)), of.end);
      }
      const Words at = of.end * Words(kRouletteOrder + 1) + min(of.order, Words(kRouletteOrder));
      if (!cells || weighs || thins) at.store(place_of + k);
      if (weighs) min(of.order, Words(t.order_cap)).store(order_of + k);
      if (!cells) continue;
      targets_of(t, k, of, Words(nowhere) + at).store(target_of + k);
      const Floats flat = Floats::load(x + k) + Floats::load(y + k);
      const int n = size - k < kLanes ? size - k : kLanes;
      spoiled = spoiled + select(first_lanes<float>(n), flat * Floats(0), Floats(0));
    }
    finite = finite && !any(!equal(spoiled, Floats(0)));
    if (kIndex && t.batch_count > 1) {
      count(t, [&](int j) LAMELLA_INLINE_LAMBDA -> LaneSums& {
        return *t.batches[t.batch_of(index[j])].sums;
      });
    } else {
      LaneSums& sums = *t.batches[0].sums;
      count(t, [&](int) LAMELLA_INLINE_LAMBDA -> LaneSums& { return sums; });
    }
    size = 0;
  }

  void add_counts(LaneSums& sums) const {
    for (int place = 0; place < kPlaces; ++place)
      for (const std::uint32_t n : counted[place]) sums.ends[place] += n;
  }

 private:
  alignas(64) std::uint32_t place_of[kRoom], target_of[kRoom], order_of[kRoom],
      spared_of_walk[kRoom];

  // sums_of(j): the sums that ended walk j counts in.
  template <class SumsOf>
  LAMELLA_INLINE void count(const LaneWalkTask& t, const SumsOf& sums_of) {
    const bool thins = t.walk.thinned_from > 0;
    const bool cells = t.estimate == LaneEstimate::cells_counted;
    const bool weighs = t.weighs();
    const int nowhere = 4 * t.cells.rows * t.cells.columns * (t.cells.both_sides ? 2 : 1);
    // A walk in a cell is counted nowhere else.
    if (thins)
      for (int j = 0; j < size; ++j) {
        LaneSums& sums = sums_of(j);
        const auto walks = std::uint32_t{1} << spared_of_walk[j];
        if (cells && !weighs)
          sums.cells[target_of[j]] += walks;
        else
          sums.ends[place_of[j]] += walks;
      }
    else if (cells && !weighs)
      for (int j = 0; j < size; ++j) ++sums_of(j).cells[target_of[j]];
    else
      for (int j = 0; j < size; ++j) ++counted[place_of[j]][j % kLanes];
    for (int channel = 0; weighs && channel < t.channels; ++channel) {
      const int first_cell = channel * nowhere;
      for (int j = 0; j < size; ++j) {
        LaneSums& sums = sums_of(j);
        std::int64_t w =
            C > 0 ? static_cast<std::int64_t>(weight[C > 0 ? channel : 0][j] * 0x1p32f)
                  : t.end_weight[static_cast<std::uint32_t>(channel) * (t.order_cap + 1) +
                                 order_of[j]];
        if (thins) w <<= spared_of_walk[j];
        sums.weights[channel * kPlaces + static_cast<int>(place_of[j])] += w;
        if (cells && target_of[j] < static_cast<std::uint32_t>(nowhere))
          sums.cells[first_cell + static_cast<int>(target_of[j])] += w;
      }
    }
  }

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

/// A set of lanes.
template <int C>
struct LaneWalks {
  LaneState<Floats, C> state;
  FloatMask free;  // lanes without a walk
  int free_count;
};

/// Moves all walks to the first set, which has room for them: the last ones are long, and a step
/// costs as much for one of them as for all of a set.
template <int C>
[[gnu::noinline]] void crowd(LaneWalks<C> (&all)[kSets]) {
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
  using State = LaneState<Floats, C>;
  move([](State & w) -> auto& { return w.wi.x; });
  move([](State & w) -> auto& { return w.wi.y; });
  move([](State & w) -> auto& { return w.wi.z; });
  move([](State & w) -> auto& { return w.y; });
  move([](State & w) -> auto& { return w.layer; });
  move([](State & w) -> auto& { return w.order; });
  move([](State & w) -> auto& { return w.index; });
  move([](State & w) -> auto& { return w.death; });
  for (int k = 0; k < 4; ++k) move([k](State & w) -> auto& { return w.numbers.s[k]; });
  for (int c = 0; c < C; ++c) move([c](State & w) -> auto& { return w.weight[c]; });
  for (int k = 1; k < kSets; ++k) {
    all[k].free = first_lanes<float>(kLanes);
    all[k].free_count = kLanes;
  }
  alignas(64) float is_free[kLanes];
  for (int k = 0; k < kLanes; ++k) is_free[k] = static_cast<float>(room >> k & 1u);
  all[0].free = Floats::load(is_free) > Floats(0);
  all[0].free_count -= count;
}

/// The walks of a task. The numbers of a walk are those of (seed, walk), so that it does not matter
/// when and where it happens.
template <int C, class Set, class Score>
[[gnu::noinline]] void walks_of(const LaneWalkTask& t, const Score& score) {
  const Set set(t.walk);
  const Vec3<Floats> incident{Floats(t.walk.wi[0]), Floats(t.walk.wi[1]), Floats(t.walk.wi[2])};
  LanePool<C, Set, Score> pool;
  using Ended = EndedWalks<C, Score::kUsesIndex>;
  Ended ended;
  std::uint64_t steps = 0, carried = 0, events_met = 0, reflected = 0;
  // 0, or not a number from the first such direction on: what is wrong with x or y is at the next
  // event wrong with z, and at the last one count_all sees it. Depths follow: they are never 0
  // times infinity, as 1 / sigma and lengths of flights are finite.
  Floats poison(0);
  using Walks = LaneWalks<C>;
  Walks all[kSets];
  for (Walks& w : all) {
    w.state.wi = incident;
    w.state.y = Floats(0);
    w.state.layer = w.state.order = w.state.index = Words(0u);
    w.state.numbers.s[0] = w.state.numbers.s[1] = Words(0u);
    w.state.numbers.s[2] = w.state.numbers.s[3] = Words(0u);
    w.state.death = Words(1u);
    for (Floats& weight : w.state.weight) weight = Floats(1);
    w.free = first_lanes<float>(kLanes);
    w.free_count = kLanes;
  }

  // Gives walks to the lanes `take`, the first of them those of place `rank`.
  const auto refill = [&](LaneState<Floats, C>& w, FloatMask take,
                          Words rank) LAMELLA_INLINE_LAMBDA {
    const WordMask words = to_word_mask(take);
    const auto word = [&](const std::uint32_t* from, Words old) LAMELLA_INLINE_LAMBDA {
      return select(words, permute(Words::load(from + pool.from), rank), old);
    };
    for (int k = 0; k < 4; ++k) w.numbers.s[k] = word(pool.numbers[k], w.numbers.s[k]);
    if constexpr (pool.kIndex) w.index = word(pool.index, w.index);
    w.death = word(pool.death, w.death);
    if constexpr (pool.kLayer) w.layer = word(pool.layer, w.layer);
    w.y = select(take, permute(Floats::load(pool.y + pool.from), rank), w.y);
    w.order = select(words, Words(0u), w.order);
    if constexpr (C > 0)
      for (Floats& weight : w.weight) weight = select(take, Floats(1), weight);
    w.wi = select(take, incident, w.wi);
  };

  const auto count_ends = [&](Walks& walks, const LaneEnds<Floats>& now, FloatMask active,
                              auto full) LAMELLA_INLINE_LAMBDA {
    LaneState<Floats, C>& w = walks.state;
    poison = multiply_add(w.wi.z, Floats(0), poison);
    Words events = shift_left<Ended::kBits>(w.order);
    events = select(to_word_mask(now.gone), events | Words(1u), events);
    if constexpr (C > 0) events = select(is_below(w.order, w.death), events, events | Words(2u));
    store_compressed(events, now.ends, ended.events + ended.size);
    if constexpr (Score::kUsesIndex)
      if (t.batch_count > 1) store_compressed(w.index, now.ends, ended.index + ended.size);
    store_compressed(w.wi.z, now.ends, ended.z + ended.size);
    if (t.estimate == LaneEstimate::cells_counted) {
      store_compressed(w.wi.x, now.ends, ended.x + ended.size);
      store_compressed(w.wi.y, now.ends, ended.y + ended.size);
    }
    if constexpr (C > 0)
      for (int c = 0; c < C; ++c)
        store_compressed(w.weight[c], now.ends, ended.weight[c] + ended.size);
    const int fallen = count(now.ends);
    ended.size += fallen;
    if constexpr (full) {
      walks.free = now.ends;
      walks.free_count = fallen;
    } else {
      walks.free = walks.free | now.ends;
      walks.free_count += fallen;
    }
    carried += static_cast<std::uint64_t>(full ? kLanes : count(active));
    if constexpr (Set::kNull) events_met += static_cast<std::uint64_t>(count(now.events));
    if constexpr (!Set::kSingle) reflected += static_cast<std::uint64_t>(count(now.reflections));
  };

  pool.fill(t, set);
  // As long as there are new walks every lane has one.
  if constexpr (Set::kSingle) {
    for (;;) {
      constexpr int kMost = kSets * kLanes;
      if (pool.to - pool.from < kMost) pool.fill(t, set);
      if (pool.to - pool.from < kMost) break;
#pragma GCC unroll 4
      for (Walks& w : all) {
        refill(w.state, w.free, rank_of(w.free));
        pool.from += w.free_count;
      }
      // One part of a step after the other, each for all sets.
      LaneDraws<Floats> draws[kSets];
      LaneEnds<Floats> now[kSets];
      const FloatMask every = first_lanes<float>(kLanes);
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k) draw(set, all[k].state, draws[k]);
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k)
        now[k] = scatter<C, true>(t.walk, set, all[k].state, draws[k], every, score);
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k) fly<C, true>(set, all[k].state, draws[k], every, now[k]);
#pragma GCC unroll 4
      for (int k = 0; k < kSets; ++k) count_ends(all[k], now[k], every, std::true_type{});
      if (ended.size >= Ended::kSize) ended.count_all(t);
      steps += kSets;
    }
  }
  for (;;) {
    int walking = 0;
    for (Walks& w : all) {
      const int available = pool.to - pool.from;
      const Words rank = rank_of(w.free);
      FloatMask take = w.free;
      if (available < kLanes)
        take = take & to_float_mask(is_below(rank, Words(static_cast<std::uint32_t>(available))));
      refill(w.state, take, rank);
      const int taken = count(take);
      pool.from += taken;
      if (pool.to - pool.from < kLanes) pool.fill(t, set);
      w.free = without(w.free, take);
      w.free_count -= taken;
      walking += kLanes - w.free_count;
    }
    if (walking == 0) break;
    if (walking <= kLanes && walking > kLanes - all[0].free_count) crowd(all);
    if constexpr (Set::kSingle) {
      for (Walks& w : all) {
        if (w.free_count == kLanes) continue;
        const FloatMask active = !w.free;
        count_ends(w, step(t.walk, set, w.state, active, score), active, std::false_type{});
        ++steps;
      }
    } else {
      // Flights of all sets cross layers by turns.
      typename Set::Flight flights[kSets];
      LaneEnds<Floats> now[kSets];
      for (int k = 0; k < kSets; ++k) {
        const FloatMask active = !all[k].free;
        flights[k].flies = without(active, active);
        if (all[k].free_count == kLanes) continue;
        LaneState<Floats, C>& w = all[k].state;
        LaneDraws<Floats> draws;
        draw(set, w, draws);
        now[k] = scatter(t.walk, set, w, draws, active, score);
        flights[k] = set.begin_flight(w.wi, draws.remaining, active & now[k].lives, w.layer, w.y);
      }
      for (bool flying = true; flying;) {
        flying = false;
        for (int k = 0; k < kSets; ++k) {
          LaneState<Floats, C>& w = all[k].state;
          if (any(flights[k].flies)) flying |= set.cross(flights[k], w.wi, w.layer, w.y);
        }
      }
      for (int k = 0; k < kSets; ++k) {
        if (all[k].free_count == kLanes) continue;
        const FloatMask active = !all[k].free;
        now[k].ends = without(active, flights[k].collides);
        count_ends(all[k], now[k], active, std::false_type{});
        ++steps;
      }
    }
    if (ended.size >= Ended::kSize) ended.count_all(t);
  }
  ended.count_all(t);
  LaneSums& sums = *t.batches[0].sums;
  ended.add_counts(sums);
  score.finish();
  sums.lane_steps += steps * static_cast<std::uint64_t>(kLanes);
  sums.busy_lane_steps += carried;
  sums.events += Set::kNull ? events_met : carried;
  sums.reflections += reflected;
  sums.finite = sums.finite && ended.finite && !any(!equal(poison, Floats(0)));
}

}  // namespace lamella::LAMELLA_ISA
