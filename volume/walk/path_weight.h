#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "volume/result/tally.h"

namespace lamella {

/// The weight of a walk per channel (C of them), and the ledger entries for the light that it
/// loses.
template <int C>
struct PathWeight {
  std::array<double, C> value;

  PathWeight() { value.fill(1); }

  /// Adds the whole weight to an entry of the ledger.
  void add_to(std::array<double, 3>& sums) const {
    for (int c = 0; c < C; ++c) sums[c] += value[c];
  }

  /// Books the weight of a walk that leaves the stack, upward or down, after `order` events: as
  /// uncollided after none, as specular too if all events were deltas.
  void leave(EnergySums& energy, bool down, std::uint64_t order, bool only_delta) const {
    if (order == 0) {
      add_to(energy.uncollided);
      return;
    }
    add_to((down ? energy.down : energy.up)[order_slot(order)]);
    if (only_delta) add_to(down ? energy.specular_down : energy.specular_up);
  }

  /// Keeps the share `kept` of each channel at an event of that order; false if the walk ends
  /// there. The rest is absorbed; from the fourth event on, where the tally no longer tells orders
  /// apart, the walk survives with the largest channel's share only. Either way a walk's ledger
  /// sums to 1. Shares above 1 (a sampled weight) are taken as they are.
  template <class Stream>
  [[nodiscard]] bool survives(const std::array<double, C>& kept, std::uint64_t order,
                              EnergySums& energy, Stream& stream) {
    std::array<double, C> on;
    double before = 0, after = 0;
    for (int c = 0; c < C; ++c) {
      on[c] = value[c] * kept[c];
      before = std::max(before, value[c]);
      after = std::max(after, on[c]);
    }
    if (after < before && (order >= kTallyOrders || after == 0)) {
      if (stream.uniform() * before >= after) {
        add_to(energy.absorbed);
        return false;
      }
      if constexpr (C == 1) return true;  // with the weight it had
      for (int c = 0; c < C; ++c) on[c] *= before / after;
    }
    for (int c = 0; c < C; ++c) {
      energy.absorbed[c] += value[c] - on[c];
      value[c] = on[c];
    }
    return true;
  }

  /// Thins (volume/result/thinning.h): false if the walk ends there, else it counts double. The
  /// ledger books the weight that thinning takes and gives, and still sums to 1.
  template <class Stream>
  [[nodiscard]] bool is_spared(EnergySums& energy, Stream& stream) {
    if (stream.uniform() < 0.5) {
      add_to(energy.thinned);
      return false;
    }
    for (int c = 0; c < C; ++c) {
      energy.thinned[c] -= value[c];
      value[c] *= 2;
    }
    return true;
  }
};

/// The share of each channel that an event of a medium keeps: the albedo, and the factor of a layer
/// whose flakes reflect by Schlick's rule. `schlick`: Scatter::schlick of the event.
template <int C, class Albedo, class Layer>
[[nodiscard]] std::array<double, C> kept_shares(const Albedo& albedo, const Layer& layer,
                                                double schlick) {
  std::array<double, C> kept;
  for (int c = 0; c < C; ++c) kept[c] = albedo[c];
  if (layer.fresnel)
    for (int c = 0; c < C; ++c) kept[c] *= layer.f0[c] + (1 - layer.f0[c]) * schlick;
  return kept;
}

}  // namespace lamella
