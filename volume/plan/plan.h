#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "phase/lanes/isa.h"
#include "phase/stack/stack.h"
#include "volume/plan/thinning.h"
#include "volume/result/cell_grid.h"

namespace lamella {

class DensityGrid;

/// analog: photons counted in cells; next_event: every collision seen from every cell or point;
/// deterministic: adding and doubling (deterministic.h), without walks.
enum class Estimator { analog, next_event, deterministic };

[[nodiscard]] std::string to_text(Estimator estimator);

/// Where walks are cut unless something else is asked for: of those that are thinned, which costs
/// next to nothing then; in colour orders are tabulated so far.
inline constexpr std::uint64_t kMaxOrder = 1000, kThinnedMaxOrder = 1 << 20,
                               kThinnedColorMaxOrder = 1 << 16;

/// What the walk carries for a stack, and nothing else. Made once from the stack; every member may
/// be widened (grey to three channels, folded to unfolded, ...) without changing the answer, which
/// is how a test and a benchmark hold the special case against the general one.
struct Plan {
  int channels = 1;                     ///< weight channels: 1 for grey, 3 for RGB
  bool folded = true;                   ///< azimuthally symmetric: phi and -phi share a cell
  bool single_layer = true;             ///< no layer to look up
  bool uniform_medium = true;           ///< all layers hold the same kind of medium
  bool transmits = true;                ///< light can leave below: tallies for that side
  std::uint64_t max_order = kMaxOrder;  ///< walks are cut after this many events, as unresolved
  Thinning thinning{};                  ///< of long walks, where it pays
  Isa isa = Isa::scalar;  ///< lanes where a kernel exists, see volume/lanes/lane_run.h

  /// Which layers of the stack have any depth; the others are left out. With a grid somewhere: any
  /// thickness, as an empty gap, too, moves the light sideways.
  std::vector<int> layers;
  /// Per layer of the stack, the grid that varies its density, or nullptr; empty without grids.
  std::vector<std::shared_ptr<const DensityGrid>> grids;

  [[nodiscard]] bool has_grids() const { return !grids.empty(); }
};

/// What is asked of walks; where nothing is, the plan chooses.
struct WalkLimits {
  std::optional<std::uint64_t> max_order{};
  std::optional<Thinning> thinning{};
};

/// The narrowest plan that models the stack. Reads its grids; throws std::invalid_argument.
[[nodiscard]] Plan make_plan(const Stack& stack, const WalkLimits& limits = {});

/// The plan of a stack whose grids are there already, one per layer or nullptr.
[[nodiscard]] Plan make_plan(const Stack& stack, const WalkLimits& limits,
                             std::vector<std::shared_ptr<const DensityGrid>> grids);

/// The plan that carries everything: three channels, no folding, layers and media looked up.
[[nodiscard]] Plan general_plan(const Stack& stack, const WalkLimits& limits = {});

/// How many events the longest walks have, roughly: the number in which those that go on become
/// fewer by e, as absorption, the way out of a slab and the way out of one-sided flakes end them.
/// Of single media a test finds 0.25 to 1.8 times the estimate.
[[nodiscard]] double longest_walk(const Stack& stack, const Plan& plan);
/// Thinning as it is for the stack's media, whether or not it pays.
[[nodiscard]] Thinning thinning_of(const Stack& stack, const Plan& plan);
/// Thinning where the longest walks are long enough for it to pay.
[[nodiscard]] Thinning thinning_for(const Stack& stack, const Plan& plan);

/// One line of `lamella explain`.
struct PlanNote {
  std::string subject;  ///< "colour", "azimuth", ...
  std::string decision;
  std::string reason;
};

[[nodiscard]] std::vector<PlanNote> explain(const Stack& stack, const Plan& plan);

}  // namespace lamella
