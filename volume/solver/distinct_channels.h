#pragma once

#include <array>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// The colour channels of a stack that differ, so that each is solved once.
struct DistinctChannels {
  std::vector<int> channels;        ///< the first of each kind
  std::array<int, 3> channel_of{};  ///< index into them, per colour channel
};

/// Albedos, f0 and the substrate decide; a substrate's law as far as some directions tell.
[[nodiscard]] DistinctChannels distinct_channels(const Stack& stack);

}  // namespace lamella
