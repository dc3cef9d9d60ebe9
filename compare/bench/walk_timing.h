#pragma once

#include <algorithm>
#include <cstdint>

#include "compare/request/stopwatch.h"
#include "volume/run/simulation.h"

namespace lamella {

// Of walks on the clock.

/// Mean relative standard error of all orders together over the targets that have met light.
[[nodiscard]] double mean_target_error(const Simulation& simulation, int targets);

/// The number of walks, a multiple of the batches, for which `advance` takes about `seconds`.
template <class Advance>
std::uint64_t calibrate(double seconds, const Advance& advance) {
  std::uint64_t walks = 2 * kBatches;
  for (;;) {
    const double taken = seconds_of([&] { advance(walks); });
    if (taken > seconds / 4 || walks > (1u << 28)) {
      const double scaled = static_cast<double>(walks) * seconds / taken / kBatches;
      return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(scaled)) * kBatches;
    }
    walks *= 4;
  }
}

/// Cycles a second of this core now: a chain of multiplications, which take 3 cycles each on
/// x86-64.
[[nodiscard]] double core_frequency();

}  // namespace lamella
