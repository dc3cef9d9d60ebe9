#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analytic/model/model.h"
#include "compare/request/run_monitor.h"
#include "volume/run/simulation.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// f of a stack at a pair of directions with its standard error, or the solver's bound, per
/// channel.
struct TruthValue {
  Rgb f, standard_error;
  std::uint64_t walks = 0;  ///< that found it; 0: the solver did
  /// Per channel, the energy of the walks that were cut, as a share of the light that came in. The
  /// direction and order that it would have left in are unknown (judge/missing_light.h).
  std::array<Estimate, 3> unresolved{};
};

/// Throws std::invalid_argument where a pair has no f: both cosines 0, or light from below where
/// the stack is closed there.
void check_pair(const Stack& stack, const DirectionPair& pair);

/// Next-event estimation at each pair, `walks` per incident direction. Where the stack is
/// reciprocal and w_o is nearer to grazing than w_i, the reversed pair is simulated instead, whose
/// variance is bounded. The delta parts are left out. mu = 0 is the limit from above; both at once
/// are refused (std::invalid_argument), like light from below a half space or an opaque substrate.
/// The walks are on lanes of the plan's set where these have a kernel for the stack.
/// The monitor's `stop`, once set, ends each simulation at its next checkpoint; `seconds`, of all
/// simulations together, ends them with fewer walks. Its keeper has a piece per incident direction,
/// and another's pairs stay 0.
[[nodiscard]] std::vector<TruthValue> truth_at(const Stack& stack, const Plan& plan,
                                               const std::vector<DirectionPair>& pairs,
                                               std::uint64_t walks, std::uint64_t seed,
                                               const RunMonitor& monitor = {},
                                               std::optional<double> seconds = {});

/// The truth at each pair from a solved stack: order 1 in closed form, the others from its modes at
/// each pair's own cosines; of thousands of pairs from a table of those where there is one
/// (volume/solver/pair_table.h). standard_error is each pair's error bound. `report`, where there
/// is one, is told after each pair.
[[nodiscard]] std::vector<TruthValue> truth_at(const DeterministicSolution& solution,
                                               const std::vector<DirectionPair>& pairs,
                                               const SolverReport& report = {});

/// Values as bytes, each number with all of its bits, and back. Throws DamagedBytes where they are
/// not `count` of them.
[[nodiscard]] std::string to_bytes(const std::vector<TruthValue>& values);
[[nodiscard]] std::vector<TruthValue> truth_values_from(std::string_view bytes, std::size_t count);

/// The reason why the solver's values are no answer, if they are none: a value or a bound that is
/// not finite, or a value that is below 0 by more than its bound.
[[nodiscard]] std::optional<std::string> why_no_answer(const std::vector<TruthValue>& values);

}  // namespace lamella
