#pragma once

#include <bit>
#include <cstdint>

#include "phase/math/real.h"

namespace lamella {

/// Long walks are thinned by halves: after event `first`, 4 first, 16 first, ... a walk ends with
/// the probability 1/2, and one that survives counts double from there. The mean does not change.
///
/// Where little is absorbed, n^-1/2 of the walks survive n events and n^-3/2 leave at the n-th, up
/// to the longest, N: events cost sqrt(N) per walk, most of them spent on few walks. If thinning
/// lets a walk reach event n with the probability s(n), cost is the sum of n^-1/2 s and variance
/// that of n^-3/2 / s; their product is least for s like n^-1/2 (Cauchy and Schwarz), where both
/// grow like log N.
struct Thinning {
  /// A power of two, or 0: never.
  std::uint32_t first = 0;
  /// Events beyond this one do not thin.
  static constexpr std::uint32_t kLast = 1u << 24;

  [[nodiscard]] bool is_on() const { return first != 0; }

  /// Halvings that a walk has survived if it is still alive after `events` events.
  [[nodiscard]] unsigned spared(std::uint64_t events) const {
    const std::uint64_t n = events < kLast ? events : kLast;
    if (!is_on() || n < first) return 0;
    return static_cast<unsigned>((std::bit_width(n) - std::bit_width(first)) / 2 + 1);
  }
  [[nodiscard]] bool halves_at(std::uint64_t events) const {
    return events <= kLast && std::has_single_bit(events) && spared(events) != spared(events - 1);
  }
  /// How many original walks a walk stands for that is still alive after `events` events.
  [[nodiscard]] double weight(std::uint64_t events) const {
    return static_cast<double>(std::uint64_t{1} << spared(events));
  }
};

/// Thinning::spared on lanes.
template <class Words>
[[nodiscard]] LAMELLA_INLINE Words spared_of(std::uint32_t first, Words events) {
  const Words n = min(events, Words(Thinning::kLast));
  const Words bit = highest_bit(max(n, Words(first))) - Words(highest_bit(first));
  return select(is_below(n, Words(first)), Words(0u), shift_right<1>(bit) + Words(1u));
}

/// The event at which thinning ends a walk, from 32 random bits; ~0 if none does.
template <class Words>
[[nodiscard]] LAMELLA_INLINE Words thinned_at(std::uint32_t first, Words bits) {
  // The number of leading zeros of 24 random bits: n zeros have the probability 2^-n.
  const Words spared = Words(23u) - highest_bit(max(shift_right<8>(bits), Words(1u)));
  const Words bit = Words(highest_bit(first)) + shift_left<1>(spared);
  return select(is_below(Words(highest_bit(Thinning::kLast)), bit), Words(~0u),
                word_with_bit(min(bit, Words(30u))));
}

}  // namespace lamella
