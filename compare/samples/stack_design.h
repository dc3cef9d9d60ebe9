#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// A stack of a data set.
struct DesignedStack {
  std::string name;  ///< "0000", or that of a stack of a list
  std::string toml;  ///< its stack file
  /// What was set: path and value.
  std::vector<std::pair<std::string, double>> values;
};

/// A Latin hypercube over the ranges of some keys of a stack: for each of them, the range is cut
/// into `count` equal parts (FROM:TO, or FROM:TO:log), and every part has one stack, at a random
/// place in it; the parts of different keys are paired at random. PATH=A,B,... takes one of the
/// values, each as often as the others. Values have six digits; they depend on (seed, count, number
/// of the key) alone. `text`: "latin:COUNT". Throws UsageError, also where a stack of the design is
/// none.
[[nodiscard]] std::vector<DesignedStack> latin_design(const Stack& stack, const std::string& text,
                                                      const std::vector<std::string>& sets,
                                                      std::uint64_t seed);

}  // namespace lamella
