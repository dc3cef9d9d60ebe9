#pragma once

#include <cstdint>

#include "compare/bench/benchmark.h"
#include "volume/run/simulation.h"

namespace lamella {

/// Squared standard error times the number of walks.
[[nodiscard]] double variance_per_walk(Estimate e, std::uint64_t walks);

/// The number of walks, a multiple of the simulation's stride, that takes about `seconds`; some are
/// walked to find it.
[[nodiscard]] std::uint64_t walks_for(double seconds, Simulation& simulation);

/// Time x variance of f at all targets of `theirs` over that of `ours`, measured in turn.
/// their_share: how many times as many walks `theirs` take. Where `ours` are on lattices, the row
/// has the ratios of variances order by order, too. what and baseline are left to the caller.
[[nodiscard]] BenchmarkRow time_variance_row(Simulation& ours, Simulation& theirs,
                                             const BenchmarkEffort& effort,
                                             std::uint64_t their_share = 1);

}  // namespace lamella
