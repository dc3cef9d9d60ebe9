#pragma once

// Walks through a grid that wait for the same thing, on lanes. Only for sources of lamella_lanes().

#include "phase/random/lane_random.h"
#include "volume/grid_walk/grid_walk_task.h"

namespace lamella::LAMELLA_ISA {

inline constexpr int kLanes = Floats::kCount;
/// Walks under way at once, at most: what the cache next to the processor holds.
inline constexpr int kWalksUnderWay = 256;

/// Walks, one per lane, with weights for C channels. Between events a walk flies from one tentative
/// collision to the next.
template <int C>
struct GridWalkers {
  Floats place[3];   ///< in voxels
  Vec3<Floats> wi;   ///< points back to where the light comes from
  Floats remaining;  ///< mean free paths of the majorant to the tentative collision ahead
  Floats scale;      ///< the extinction over a voxel's density, or rho sigma(w)
  Floats weight[C];
  Words slot, order;
  Words accept;  ///< decides on the tentative collision ahead
  WalkNumbers<Words> numbers;
};

/// Walks that wait. A register may be stored where the last walk begins.
template <int C>
struct WalkPile {
  static constexpr int kRows = 15 + C, kRoom = kWalksUnderWay + kLanes;
  int size = 0;
  alignas(64) std::uint32_t rows[kRows][kRoom];

  LAMELLA_INLINE void load(int first, GridWalkers<C>& w) const {
    for_each_row(w, [&](int row, auto& to) LAMELLA_INLINE_LAMBDA {
      const Words words = Words::load(rows[row] + first);
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(to)>, Floats>)
        to = from_bits(words);
      else
        to = words;
    });
  }
  /// Adds the walks of these lanes.
  LAMELLA_INLINE void add(const GridWalkers<C>& w, FloatMask which) {
    for_each_row(w, [&](int row, const auto& from) LAMELLA_INLINE_LAMBDA {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(from)>, Floats>)
        store_compressed(bits_of(from), which, rows[row] + size);
      else
        store_compressed(from, which, rows[row] + size);
    });
    size += count(which);
  }

 private:
  // f(row, register) for all that walks carry.
  template <class Walkers, class F>
  LAMELLA_INLINE static void for_each_row(Walkers& w, const F& f) {
    for (int a = 0; a < 3; ++a) f(a, w.place[a]);
    f(3, w.wi.x);
    f(4, w.wi.y);
    f(5, w.wi.z);
    f(6, w.remaining);
    f(7, w.scale);
    f(8, w.slot);
    f(9, w.order);
    f(10, w.accept);
    for (int k = 0; k < 4; ++k) f(11 + k, w.numbers.s[k]);
    for (int c = 0; c < C; ++c) f(15 + c, w.weight[c]);
  }
};

}  // namespace lamella::LAMELLA_ISA
