#pragma once

#include <vector>

#include "phase/stack/stack.h"
#include "volume/plan/plan.h"
#include "volume/result/estimator.h"
#include "volume/result/tally.h"
#include "volume/walk/departures.h"
#include "volume/walk/scorers.h"
#include "volume/walk/walk_batches.h"

namespace lamella {

/// What the batches of a simulation with interfaces run: walks `from` to `to` (not included) of a
/// batch. targets: cells; points: f at points instead, next-event (none: energies alone). Of deltas
/// f has no value: they are in the energies alone.
[[nodiscard]] RunBatch boundary_runner(const Stack& stack, const Plan& plan, Direction incident,
                                       std::uint64_t seed, Estimator estimator,
                                       const CellTargets& targets,
                                       const std::vector<Direction>* points,
                                       std::vector<BatchTally>& batches);

/// The same walks, one by one.
[[nodiscard]] FollowWalk boundary_follower(const Stack& stack, const Plan& plan,
                                           std::uint64_t seed);

}  // namespace lamella
