#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "phase/math/direction.h"
#include "phase/math/order.h"

namespace lamella {

/// Slot of order 0, light that met interfaces alone: the last one, and only where there are some.
inline constexpr int kZeroSlot = kTallyOrders;

[[nodiscard]] constexpr int order_slot(std::uint64_t events) {
  if (events == 0) return kZeroSlot;
  return events >= kTallyOrders ? kTallyOrders - 1 : static_cast<int>(events) - 1;
}

/// Walks are dealt out to this many batches, walk i to batch i mod kBatches; standard errors come
/// from the scatter between them.
inline constexpr int kBatches = 128;

/// Sums of the energies over the walks of a batch, per channel. Each is counted where it happens;
/// none is computed as 1 less the others.
struct EnergySums {
  using Channels = std::array<double, 3>;
  std::array<Channels, kTallyOrders> up{},
      down{};                       ///< left the stack there, after that many events
  Channels zero_up{}, zero_down{};  ///< left there after interfaces alone, `uncollided` apart
  Channels specular_up{}, specular_down{};  ///< the part of up, down and zero that met deltas only
  Channels uncollided{}, absorbed{}, unresolved{};
  Channels lost{};     ///< in the shadow of facets, by single scattering at interfaces
  Channels thinned{};  ///< taken by thinning less given back: 0 on average
};

/// The use of the lanes.
struct LaneUse {
  double occupancy = 0;  ///< lanes that had a walk at each step, of all
  double null = 0;       ///< of these, lanes whose collision was a null one
};

/// The counts of one batch of walks.
struct BatchTally {
  std::uint64_t walks = 0;
  std::uint64_t collisions = 0;
  std::uint64_t holes = 0;  ///< rays among grains that began inside of one
  EnergySums energy;
  /// Sums over walks of estimates of f [1/sr]: [slot of the order][channel][target], targets being
  /// cells or points.
  std::vector<double> f;
};

/// A mean over batches and its standard error.
struct Estimate {
  double value = 0, standard_error = 0;
};

/// Mean per walk and standard error of a quantity from its sums per batch and the batches' walks.
template <class SumOf>
[[nodiscard]] Estimate batch_estimate(const std::vector<BatchTally>& batches, const SumOf& sum_of) {
  double sum = 0, walks = 0;
  for (const BatchTally& b : batches) {
    sum += sum_of(b);
    walks += static_cast<double>(b.walks);
  }
  if (walks == 0) return {};
  const double mean = sum / walks;
  double variance = 0;
  for (const BatchTally& b : batches) {
    const double excess = sum_of(b) - mean * static_cast<double>(b.walks);
    variance += excess * excess;
  }
  const double n = static_cast<double>(batches.size());
  return {mean, std::sqrt(variance * n / (n - 1)) / walks};
}

}  // namespace lamella
