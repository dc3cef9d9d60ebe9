#pragma once

#include <cmath>
#include <cstddef>

#include "phase/random/random.h"

namespace lamella::testing {

/// Numbers of random stacks, from a stream of a fixed seed.
struct Draw {
  RandomStream stream;

  double between(double low, double high) { return low + (high - low) * stream.uniform(); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(n * stream.uniform()); }
  /// Short numbers, for messages that can be read.
  double rounded(double low, double high) { return std::round(100 * between(low, high)) / 100; }
};

}  // namespace lamella::testing
