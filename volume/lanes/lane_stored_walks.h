#pragma once

// Walks that no lane has, until lanes take them. Only for sources of lamella_lanes().

#include "volume/lanes/lane_pool.h"

namespace lamella::LAMELLA_ISA {

/// Walks between two steps, the last one first. State: LaneState, or BoundedState with what it met.
/// kMost: walks that there is room for. kPlaced: each has its own layer and its count of steps;
/// else all are in one layer, and their steps are their events. kIndex: their indices are kept.
template <int C, class State, int kMost, bool kPlaced, bool kIndex>
struct StoredWalks {
  static constexpr bool kMet = requires(State w) { w.met; };
  static constexpr int kRoom = kMost + kLanes,
                       kRows = 12 + C + (kMet ? 1 : 0) + (kPlaced ? 2 : 0) + (kIndex ? 1 : 0);
  int size = 0;
  bool has_point = false, has_shift = false;  ///< of lattices
  alignas(64) std::uint32_t rows[kRows][kRoom];

  /// f(a number of the walks, its row) for all that is stored.
  template <class F>
  LAMELLA_INLINE void each(State& w, const F& f) const {
    int row = 0;
    const auto word = [&](Words& x) LAMELLA_INLINE_LAMBDA { f(x, row++); };
    const auto number = [&](Floats& x) LAMELLA_INLINE_LAMBDA {
      Words bits = bits_of(x);
      word(bits);
      x = from_bits(bits);
    };
    number(w.wi.x), number(w.wi.y), number(w.wi.z), number(w.y);
    word(w.order), word(w.death);
    for (Words& state : w.numbers.s) word(state);
    for (int c = 0; c < C; ++c) number(w.weight[c]);
    if constexpr (kMet) word(w.met);
    if constexpr (kPlaced) word(w.layer), word(w.step);
    if constexpr (kIndex) word(w.index);
    if (has_point) word(w.point);
    if (has_shift) word(w.shift);
  }
  LAMELLA_INLINE void push(State w, FloatMask lanes) {
    each(w, [&](Words& x, int row)
                LAMELLA_INLINE_LAMBDA { store_compressed(x, lanes, rows[row] + size); });
    size += count(lanes);
  }
  /// Gives the last walks to the lanes `free`, as far as there are some; which lanes they are.
  LAMELLA_INLINE FloatMask pop(State& w, FloatMask free) {
    const Words rank = rank_of(free);
    const int wanted = count(free), taken = wanted < size ? wanted : size;
    const FloatMask take =
        free & to_float_mask(is_below(rank, Words(static_cast<std::uint32_t>(taken))));
    const WordMask words = to_word_mask(take);
    size -= taken;
    each(w, [&](Words& x, int row) LAMELLA_INLINE_LAMBDA {
      x = select(words, permute(Words::load(rows[row] + size), rank), x);
    });
    return take;
  }
};

}  // namespace lamella::LAMELLA_ISA
