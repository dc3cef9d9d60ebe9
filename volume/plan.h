#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "phase/isa.h"
#include "phase/stack.h"
#include "volume/cell_grid.h"

namespace lamella {

class DensityGrid;

/// analog: photons counted in cells; next_event: every collision seen from every cell or point;
/// deterministic: adding and doubling (deterministic.h), without walks.
enum class Estimator { analog, next_event, deterministic };

[[nodiscard]] std::string to_text(Estimator estimator);

/// What the walk carries for a stack, and nothing else. Made once from the stack; every member may
/// be widened (grey to three channels, folded to unfolded, ...) without changing the answer, which
/// is how a test and a benchmark hold the special case against the general one.
struct Plan {
  int channels = 1;                ///< weight channels: 1 for grey, 3 for RGB
  bool folded = true;              ///< azimuthally symmetric: phi and -phi share a cell
  bool single_layer = true;        ///< no layer to look up
  bool uniform_medium = true;      ///< all layers hold the same kind of medium
  bool transmits = true;           ///< light can leave below: tallies for that side
  std::uint64_t max_order = 1000;  ///< walks are cut after this many events, as unresolved
  Isa isa = Isa::scalar;           ///< lanes where a kernel exists, see volume/lane_run.h

  /// Which layers of the stack have any depth; the others are left out. With a grid somewhere: any
  /// thickness, as an empty gap, too, moves the light sideways.
  std::vector<int> layers;
  /// Per layer of the stack, the grid that varies its density, or nullptr; empty without grids.
  std::vector<std::shared_ptr<const DensityGrid>> grids;

  [[nodiscard]] bool has_grids() const { return !grids.empty(); }
};

/// The narrowest plan that models the stack. Reads its grids; throws std::invalid_argument.
[[nodiscard]] Plan make_plan(const Stack& stack, std::uint64_t max_order = 1000);

/// The plan of a stack whose grids are there already, one per layer or nullptr.
[[nodiscard]] Plan make_plan(const Stack& stack, std::uint64_t max_order,
                             std::vector<std::shared_ptr<const DensityGrid>> grids);

/// The plan that carries everything: three channels, no folding, layers and media looked up.
[[nodiscard]] Plan general_plan(const Stack& stack, std::uint64_t max_order = 1000);

/// One line of `lamella explain`.
struct PlanNote {
  std::string subject;  ///< "colour", "azimuth", ...
  std::string decision;
  std::string reason;
};

[[nodiscard]] std::vector<PlanNote> explain(const Stack& stack, const Plan& plan);

}  // namespace lamella
