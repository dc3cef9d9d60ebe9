#pragma once

#include <cstdint>
#include <vector>

#include "volume/plan/plan.h"
#include "volume/result/tally.h"
#include "volume/walk/scorers.h"

namespace lamella {

/// The walks that lanes of float take (volume/lanes/lane_run.h), with the same random numbers and
/// from the same source, in double: what the two differ by is rounding, which so can be told from
/// noise: walks that are counted, which next-event estimation takes others than where
/// takes_null_collisions (volume/lanes/lane_setting.h) says so. Walks 0, 1, ... walks - 1, walk i
/// in batch i mod `batches`; energies, and analog counts in cells. For stacks without a reason in
/// why_not_lanes.
[[nodiscard]] std::vector<BatchTally> replay_in_double(const Stack& stack, const Plan& plan,
                                                       Direction incident, std::uint64_t seed,
                                                       int batches, std::uint64_t walks,
                                                       const CellTargets& cells);

}  // namespace lamella
