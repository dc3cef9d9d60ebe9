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

/// What the batches of a simulation with grids run: walks `from` to `to` (not included) of a batch,
/// and the instruction set that follows them.
struct GridRunner {
  RunBatch run;
  Isa isa = Isa::scalar;
};
/// The light enters uniformly over the tile and counts wherever it leaves: f is the tile's mean.
/// targets: cells; points: f at points instead, next-event (none: energies alone).
[[nodiscard]] GridRunner grid_runner(const Stack& stack, const Plan& plan, Direction incident,
                                     std::uint64_t seed, Estimator estimator,
                                     const CellTargets& targets,
                                     const std::vector<Direction>* points,
                                     std::vector<BatchTally>& batches);

/// The same walks, one by one; |mu| of w_i is at least kGridGrazing.
[[nodiscard]] FollowWalk grid_follower(const Stack& stack, const Plan& plan, std::uint64_t seed);

}  // namespace lamella
