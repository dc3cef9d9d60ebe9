#pragma once

#include <cstdint>

#include "phase/lanes/isa.h"

namespace lamella {

/// For a benchmark: what lanes sorted by medium would have to do besides walking. So many times,
/// the twelve numbers of each walk of four sets of lanes are moved so that walks of one of two
/// media come first; which medium a walk is in is drawn anew each time. Returns a sum of what was
/// moved.
LAMELLA_LANE_FUNCTION(std::uint32_t, sort_walks, (std::uint32_t steps))

/// The lanes of four sets.
LAMELLA_LANE_FUNCTION(int, sorted_walks, ())

}  // namespace lamella
