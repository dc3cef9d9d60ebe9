#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "phase/lanes/isa.h"
#include "phase/stack/stack.h"
#include "volume/result/order_one.h"
#include "volume/result/tally.h"
#include "volume/result/thinning.h"
#include "volume/result/walk_sampling.h"

namespace lamella {

class DensityGrid;

/// The order at which walks are cut unless another is asked for; a higher one where walks are
/// thinned, as long walks then cost next to nothing. The brightest channel decides, in colour as
/// well.
inline constexpr std::uint64_t kMaxOrder = 1000, kThinnedMaxOrder = 1 << 20;

/// Whether lanes walk in one layer at a time: where that is faster, or asked for by tests and
/// benchmarks.
enum class LayerTurns { where_faster, never, always };

/// The features that the walk carries for a stack, and no others. Made once from the stack; every
/// member may be widened (grey to three channels, folded to unfolded, ...) without changing the
/// answer. A test and a benchmark compare the special case with the general one in this way.
struct Plan {
  int channels = 1;                     ///< weight channels: 1 for grey, 3 for RGB
  bool folded = true;                   ///< azimuthally symmetric: phi and -phi share a cell
  bool single_layer = true;             ///< no layer to look up
  bool uniform_medium = true;           ///< all layers hold the same kind of medium
  bool boundaries = false;              ///< interfaces, or a substrate beyond Lambert's law
  bool rough_boundaries = false;        ///< some of them rough: order 0 is a lobe
  bool transmits = true;                ///< light can leave below: tallies for that side
  std::uint64_t max_order = kMaxOrder;  ///< walks are cut after this many events, as unresolved
  Thinning thinning{};                  ///< of long walks, where it pays
  Sampling sampling = Sampling::random;
  OrderOne order_one = OrderOne::walked;  ///< exact: where a result takes it, see Simulation
  Isa isa = Isa::scalar;  ///< lanes where a kernel exists, see volume/lanes/lane_run.h
  LayerTurns layer_turns = LayerTurns::where_faster;  ///< of lanes, see walks_by_layer

  /// Which layers of the stack have any depth; the others are left out. With a grid somewhere: any
  /// thickness, as an empty gap, too, moves the light sideways.
  std::vector<int> layers;
  /// Per layer of the stack, the grid that varies its density, or nullptr; empty without grids.
  std::vector<std::shared_ptr<const DensityGrid>> grids;
  /// Warnings about the grids' files, one line each, for people.
  std::vector<std::string> warnings;

  /// Slots of orders in a tally: order 0 has one where there are interfaces.
  [[nodiscard]] int order_slots() const { return boundaries ? kZeroSlot + 1 : kTallyOrders; }
  [[nodiscard]] bool has_grids() const { return !grids.empty(); }
};

/// Limits that the user asked for; without one the plan chooses.
struct WalkLimits {
  std::optional<std::uint64_t> max_order{};
  std::optional<Thinning> thinning{};
  Sampling sampling = Sampling::random;
  OrderOne order_one = OrderOne::walked;
};

/// The narrowest plan that models the stack. Reads its grids; throws std::invalid_argument.
[[nodiscard]] Plan make_plan(const Stack& stack, const WalkLimits& limits = {});

/// The plan of a stack whose grids are there already, one per layer or nullptr.
[[nodiscard]] Plan make_plan(const Stack& stack, const WalkLimits& limits,
                             std::vector<std::shared_ptr<const DensityGrid>> grids);

/// The plan that carries everything: three channels, no folding, layers and media looked up.
[[nodiscard]] Plan general_plan(const Stack& stack, const WalkLimits& limits = {});

}  // namespace lamella
