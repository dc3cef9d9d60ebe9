#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "phase/lanes/isa.h"
#include "phase/stack/stack.h"
#include "volume/plan/plan.h"
#include "volume/run/simulation.h"

namespace lamella {

/// Settings that only walks have a use for, in the order in which messages name them.
enum class WalkSetting { walks, target_error, max_order, thin_from, seconds };

/// As the command line spells it: "--walks", "--target-error", ...
[[nodiscard]] std::string to_text(WalkSetting setting);

/// The incident directions of a truth where none are named: theta_i = 0, 30, 60, 80 degrees at
/// phi_i = 0.
[[nodiscard]] std::vector<Direction> default_directions();

/// Which truth is asked for, of which stack, and at what effort. It runs on the threads of the
/// calling thread's task arena.
struct TruthRequest {
  Stack stack{};
  /// Stacks whose mean is asked for in the place of `stack`, which then is the first of them: the
  /// places of a map (compare/maps/surface_stack.h). Empty: `stack` alone.
  std::vector<Stack> texels{};
  /// Incident, unit. Below z = 0: light from below, where the stack is open there.
  std::vector<Direction> directions = default_directions();
  std::optional<Estimator> estimator{};  ///< nothing: `auto`, whichever suits the stack
  /// Walks per incident direction and what ends them earlier; `seconds` of the solver: in all.
  /// Where `given` names none of these settings the clock ends walks, too (first_look.h).
  StopRule effort{.walks = 1000000, .target_error = {}, .seconds = {}};
  /// Where walks are cut and thinned, empty: as the plan chooses; which numbers they take, and
  /// whether order 1 is exact.
  WalkLimits limits{.sampling = Sampling::rqmc, .order_one = OrderOne::exact};
  /// The settings above that were asked for by name; if the estimator is left open, each of them is
  /// a reason for walks.
  std::vector<WalkSetting> given{};
  double tolerance = 1e-4;  ///< of the solver, relative to the mean over the azimuth
  /// Of a run that is repeated: the nodes and modes at which the solver's refinement ended, even if
  /// the clock ended it.
  struct SolverEnd {
    int nodes;
    std::array<int, 3> modes;  ///< per colour channel
    /// DeterministicAccuracy::integrated_from, where it was recorded.
    std::optional<int> integrated_from{};
  };
  std::optional<SolverEnd> solver_end{};
  /// The same of each of the texels. Empty: not recorded.
  std::vector<SolverEnd> texel_ends{};
  CellGrid cells{};  ///< per hemisphere
  std::uint64_t seed = 1;
  Isa isa = Isa::scalar;
};

/// "auto", or the estimator's name.
[[nodiscard]] std::string estimator_asked(const TruthRequest& request);

/// The estimator that a text names, nothing being `auto`. Throws UsageError for any other text.
[[nodiscard]] std::optional<Estimator> parse_estimator(const std::string& text);

/// The narrowest plan for the request's stack, with its limits and instruction set. Reads the
/// stack's grids; throws std::invalid_argument.
[[nodiscard]] Plan plan_of(const TruthRequest& request);

}  // namespace lamella
