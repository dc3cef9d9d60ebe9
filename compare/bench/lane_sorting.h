#pragma once

#include <cstdint>

#include "phase/lanes/isa.h"

namespace lamella {

/// For a benchmark: what lanes sorted by medium would have to do besides walking. In each of
/// `steps` steps the twelve numbers of each walk of four sets of lanes are moved so that the walks
/// of one of two media come first; the medium of a walk is drawn anew in each step. Returns a sum
/// over the numbers moved, so that the compiler keeps the work.
LAMELLA_LANE_FUNCTION(std::uint32_t, sort_walks, (std::uint32_t steps))

/// The lanes of four sets.
LAMELLA_LANE_FUNCTION(int, sorted_walks, ())

}  // namespace lamella
