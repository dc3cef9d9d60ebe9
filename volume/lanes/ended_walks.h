#pragma once

// Walks that lanes have ended, on their way into sums. Only for sources of lamella_lanes().

#include "volume/lanes/lane_cells.h"
#include "volume/lanes/lane_pool.h"

namespace lamella::LAMELLA_ISA {

/// Whether walks that leave are counted in cells: through interfaces next-event estimation counts
/// those that no event has sent.
template <bool kBounded>
[[nodiscard]] LAMELLA_INLINE bool counts_in_cells(const LaneWalkTask& t) {
  return t.estimate == LaneEstimate::cells_counted ||
         (kBounded && t.estimate == LaneEstimate::cells_next_event);
}

/// Walks that ended, until there are enough of them to count them at a stretch. kIndex: each in the
/// sums of the batch that its index tells. kBounded: of stacks with interfaces.
template <int C, bool kIndex, bool kBounded>
struct EndedWalks {
  static constexpr int kSize = 512, kRoom = kSize + (kSets + 1) * kLanes;
  static constexpr int kPlaces = kEndRows<kBounded> * static_cast<int>(kRouletteOrder + 1);
  static constexpr int place(WalkEnd end, std::uint32_t order) {
    return static_cast<int>(end) * static_cast<int>(kRouletteOrder + 1) + static_cast<int>(order);
  }
  // Events, and as last bits whether one ended the walk and, of walks with weights, whether that
  // was by thinning or the one too many.
  static constexpr int kBits = kBounded ? kBoundedBits : C > 0 ? 2 : 1;
  /// Slots of orders in cells: behind the others order 0, of light that met rough interfaces.
  static constexpr int kSlots = static_cast<int>(kRouletteOrder) + (kBounded ? 1 : 0);
  int size = 0;
  std::uint64_t told = 0;  // of those counted
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
    told += static_cast<std::uint64_t>(size);
    if constexpr (kIndex)
      if (t.estimate == LaneEstimate::walk_by_walk) return record_all(t);
    const bool thins = t.walk.thinned_from > 0;
    const bool cells = counts_in_cells<kBounded>(t);
    const bool weighs = t.weighs();
    const int nowhere = kSlots * t.cells.rows * t.cells.columns * (t.cells.both_sides ? 2 : 1);
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
      if constexpr (kBounded) to_boundary_rows(met, of);
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

  // Rows of walks through boundaries.
  LAMELLA_INLINE static void to_boundary_rows(Words met, LaneEnd<Words>& of) {
    const auto bit = [&](std::uint32_t value)
                         LAMELLA_INLINE_LAMBDA { return !equal(met & Words(value), Words(0u)); };
    const WordMask straight =
        bit(kMetDeltasBit) & equal(of.order, Words(0u)) &
        is_below(of.end, Words(static_cast<std::uint32_t>(WalkEnd::absorbed)));
    of.end = select(straight, of.end + Words(static_cast<std::uint32_t>(kDeltaRow)), of.end);
    of.end = select(bit(kLostBit), Words(static_cast<std::uint32_t>(kLostRow)), of.end);
    of.end = select(bit(kCutBit), Words(static_cast<std::uint32_t>(WalkEnd::unresolved)), of.end);
  }

  // Walk by walk, each to its place.
  [[gnu::noinline]] void record_all(const LaneWalkTask& t) {
    const LaneRecords& to = t.records;
    Floats spoiled(0);
    for (int k = 0; k < size; k += kLanes) {
      const Words met = Words::load(events + k);
      LaneEnd<Words> of(shift_right<kBits>(met), !equal(met & Words(1u), Words(0u)),
                        to_word_mask(Floats::load(z + k) > Floats(0)), t.walk.max_order);
      if constexpr (kBounded) to_boundary_rows(met, of);
      of.order.store(order_of + k);
      // Of ends within the stack no light is told.
      const auto row = [](int end)
                           LAMELLA_INLINE_LAMBDA { return Words(static_cast<std::uint32_t>(end)); };
      const WordMask left = is_below(of.end, row(static_cast<int>(WalkEnd::absorbed))) |
                            is_below(row(kLostRow), of.end);
      select(left, of.end + Words(1u), Words(0u)).store(place_of + k);
      const Floats flat = Floats::load(x + k) + Floats::load(y + k);
      const int n = size - k < kLanes ? size - k : kLanes;
      spoiled = spoiled + select(first_lanes<float>(n), flat * Floats(0), Floats(0));
    }
    finite = finite && !any(!equal(spoiled, Floats(0)));
    const std::uint32_t first = t.batches[0].index_low;
    for (int j = 0; j < size; ++j) {
      const std::uint32_t walk = index[j] - first;  // the stride is 1
      to.x[walk] = x[j];
      to.y[walk] = y[j];
      to.z[walk] = z[j];
      to.events[walk] = order_of[j];
      to.end[walk] = place_of[j];
      for (int c = 0; c < C; ++c) to.weight[c][walk] = weight[c][j];
    }
    size = 0;
  }

  // sums_of(j): the sums that ended walk j counts in.
  template <class SumsOf>
  LAMELLA_INLINE void count(const LaneWalkTask& t, const SumsOf& sums_of) {
    const bool thins = t.walk.thinned_from > 0;
    const bool cells = counts_in_cells<kBounded>(t);
    const bool weighs = t.weighs();
    const int nowhere = kSlots * t.cells.rows * t.cells.columns * (t.cells.both_sides ? 2 : 1);
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
    const bool shared = C == 0 && t.walk.forced_flights > 0;
    const auto share = [&](int j) { return std::llround(weight[0][j] * kPointUnits); };
    if (shared)
      for (int j = 0; j < size; ++j) sums_of(j).shares[place_of[j]] += share(j);
    for (int channel = 0; weighs && channel < t.channels; ++channel) {
      const int first_cell = channel * nowhere;
      for (int j = 0; j < size; ++j) {
        LaneSums& sums = sums_of(j);
        std::int64_t w =
            C > 0 ? static_cast<std::int64_t>(weight[C > 0 ? channel : 0][j] * 0x1p32f)
                  : t.end_weight[static_cast<std::uint32_t>(channel) * (t.order_cap + 1) +
                                 order_of[j]];
        if (thins) w <<= spared_of_walk[j];
        if (shared) w = std::llround(static_cast<double>(w) * weight[0][j]);
        sums.weights[channel * kPlaces + static_cast<int>(place_of[j])] += w;
        if (cells && target_of[j] < static_cast<std::uint32_t>(nowhere))
          sums.cells[first_cell + static_cast<int>(target_of[j])] += w;
      }
    }
  }

  // [slot][target], or `elsewhere`.
  LAMELLA_INLINE Words targets_of(const LaneWalkTask& t, int k, const LaneEnd<Words>& of,
                                  Words elsewhere) const {
    const WordMask down = equal(of.end, Words(static_cast<std::uint32_t>(WalkEnd::down)));
    WordMask left = of.end < Words(static_cast<std::uint32_t>(t.cells.both_sides ? WalkEnd::absorbed
                                                                                 : WalkEnd::down));
    if constexpr (!kBounded) left = left & (of.order > Words(0u));
    // What events sent out is in the sums already.
    if (t.estimate != LaneEstimate::cells_counted) left = left & equal(of.order, Words(0u));
    const int cells = t.cells.rows * t.cells.columns;
    const Words below = select(down, Words(cells), Words(0u));
    Words slot = max(min(of.order, Words(kRouletteOrder)), Words(1u)) - Words(1u);
    if constexpr (kBounded) slot = select(equal(of.order, Words(0u)), Words(kRouletteOrder), slot);
    const Words target =
        cell_of(t.cells, {Floats::load(x + k), Floats::load(y + k), Floats::load(z + k)}) + below +
        slot * Words(t.cells.both_sides ? 2 * cells : cells);
    return select(left, target, elsewhere);
  }
};

}  // namespace lamella::LAMELLA_ISA
