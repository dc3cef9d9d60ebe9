#pragma once

#include <cstdint>

#include "phase/lanes/isa.h"
#include "volume/lanes/lane_way_block.h"
#include "volume/walk/incident_law.h"

namespace lamella {

/// Directions that next-event estimation sends light to, structure of arrays; `padded` is `count`
/// rounded up to a multiple of 16, places beyond `count` repeat a valid direction.
struct LanePoints {
  int count = 0, padded = 0, up = 0;
  const float *x = nullptr, *y = nullptr, *z = nullptr;
  /// sigma(-w_o) / |mu_o| of a layer, and the optical depth between the layer and the exit:
  /// [layer][padded], and [point][kMostLaneLayers + 1]. The last layer is the substrate's.
  const float *rate = nullptr, *beyond = nullptr;
  const float *rate_by_point = nullptr, *beyond_by_point = nullptr;
};

/// Where leaving light is counted, and where next-event estimation sends it; see CellGrid.
struct LaneCells {
  bool on = false, folded = false, both_sides = false;
  bool symmetric = false;  ///< about z: what light meets on its way out depends on mu alone
  int rows = 0, columns = 0, phi_cells = 0;
  int padded_columns = 0;                                    ///< next event: a multiple of 16
  float azimuth_turns = 0;                                   ///< of w_i, as a fraction of a turn
  const float *column_cos = nullptr, *column_sin = nullptr;  ///< of the columns' first edges
  float* scratch = nullptr;  ///< kLaneScratchRows rows + 2 padded_columns numbers
};
/// mu, its inverse, what terms have in its place, its sine, and the attenuation upwards and
/// downwards; rows padded to 16.
inline constexpr int kLaneScratchRows = 6;

/// Fixed point makes sums independent of their order: terms are rounded to 2^-32.
inline constexpr double kPointUnits = 0x1p32;
/// The largest term that fixed point takes.
inline constexpr double kPointLimit = 0x1p18;
/// 1 / |mu| of a direction within a cell is at most this, times the square root of the rows.
inline constexpr double kLargestInverseMu = 0x1.7p8;

/// What the walks of a task are estimated by.
enum class LaneEstimate { energies, cells_counted, points, cells_next_event, walk_by_walk };

/// What a batch's walks add up to.
struct LaneSums {
  /// Ends of walks [WalkEnd][order], orders from 4 on together. Unthinned: number of walks.
  /// Thinned: each adds its multiplicity 2^k; a walk without weights that thinning ended adds the
  /// multiplicity it would have had. For walks without weights and colour that are counted in
  /// cells, `cells` holds those that left and, behind the cells, the others.
  std::uint64_t* ends = nullptr;
  /// Weights of walks at their end [channel][WalkEnd][order] in units of 1 / kPointUnits; only if
  /// the task has weights or three channels.
  std::int64_t* weights = nullptr;
  /// cells_counted: walks [slot][target] and, behind them, as `ends`; or the weights of walks
  /// [channel][slot][target].
  std::int64_t* cells = nullptr;
  /// Where flights are forced: shares of walks in units of 1 / kPointUnits, at their end as `ends`,
  /// and those that left on such a flight, or that roulette took [up, down, taken][events - 1].
  std::int64_t *shares = nullptr, *forced = nullptr;
  /// Next event: p(w_i -> w_o) exp(-tau) (on cells, over |mu_o|) times the weight, if the task has
  /// weights or three channels: [slot][channel][place].
  std::int64_t* targets = nullptr;
  /// Steps taken times lanes; how many of these lanes had a walk; how many of those met an event:
  /// the others had a null collision.
  std::uint64_t lane_steps = 0, busy_lane_steps = 0, events = 0;
  std::uint64_t reflections = 0;  ///< the substrate's among the events
  std::uint64_t meetings = 0;     ///< with interfaces, which are no events
  /// False where a walk met a number that is not finite.
  bool finite = true;
};

/// What became of the walks of a task of one batch, walk by walk: the j-th number is that of the
/// walk that began as the j-th. Rows have room for 64 walks more than there are.
struct LaneRecords {
  float *wi_x = nullptr, *wi_y = nullptr, *wi_z = nullptr;  ///< where w_i is drawn
  float *x = nullptr, *y = nullptr, *z = nullptr;           ///< -w_o
  std::uint32_t* events = nullptr;                          ///< that counted
  /// 0 where no light left, else 1 more than the row of the walk's end: up, down, or those of
  /// straight_row and kDeltaRow.
  std::uint32_t* end = nullptr;
  float* weight[3] = {};  ///< of walks with weights, per channel
};

/// Walks of a batch: the j-th has the index (index_high, index_low + j index_stride) of the task,
/// which does not overflow.
struct LaneBatch {
  std::uint32_t index_low = 0, walks = 0;
  LaneSums* sums = nullptr;
  /// With a lattice: the point of the first walk, and the shift of the batch's lattice.
  std::uint32_t point = 0, shift = 0;
  /// Next event through interfaces: the ways that the first walk takes, and behind them those of
  /// later ones; how many walks lie before the first that share its ways.
  const LaneWays* ways = nullptr;
  std::uint32_t walks_before = 0;
};

/// Walks of one batch, or of neighbouring batches: while the longest walks of one go on, walks of
/// the next fill the other lanes.
struct LaneWalkTask {
  WalkSetting<float> walk;
  /// One layer of one medium without weights: volume/lanes/lane_one_medium.cpp, or by null
  /// collisions volume/lanes/lane_counted_flakes.cpp. Else volume/lanes/lane_any_stack.cpp, or
  /// layer by layer volume/lanes/lane_layered_stack.cpp.
  bool one_medium = false;
  bool weights = false;  ///< walks carry weights, one per channel; else the order alone tells them
  int channels = 1;
  LaneEstimate estimate = LaneEstimate::energies;
  LanePoints points;
  LaneCells cells;
  /// Without weights and with three channels: by order, the weight of a walk at its end, and the
  /// weight that an event sends out; [channel][order_cap + 1].
  const std::int64_t* end_weight = nullptr;
  const float* event_weight = nullptr;
  std::uint32_t order_cap = 0;
  /// Of thinned walks: what next-event terms are scaled by, a power of two.
  float term_scale = 1;
  /// Next event through interfaces, at points and in cells: whether all walks take the same ways;
  /// padded number of targets.
  bool same_ways = false;
  int way_targets = 0;
  LaneWayPlaces way_places;
  std::uint32_t index_high = 0, index_stride = 0;
  /// Of several batches the number is the index modulo the stride, a power of two, less that of the
  /// first. Steps and events count in the first one's sums.
  const LaneBatch* batches = nullptr;
  std::uint32_t batch_count = 0;
  IncidentLaw incident_law = IncidentLaw::fixed;
  LaneRecords records;  ///< walk_by_walk; sums then count nothing

  [[nodiscard]] LAMELLA_INLINE std::uint32_t batch_of(std::uint32_t index) const {
    return batch_count == 1 ? 0 : (index - batches[0].index_low) & (index_stride - 1);
  }
  /// Whether the number of a walk that ends is asked for.
  [[nodiscard]] LAMELLA_INLINE bool asks_for_index() const {
    return batch_count > 1 || estimate == LaneEstimate::walk_by_walk;
  }
  [[nodiscard]] bool weighs() const { return weights || channels > 1; }
};

LAMELLA_LANE_FUNCTION(void, walk_lanes, (const LaneWalkTask& task))
LAMELLA_LANE_FUNCTION(void, count_flake_lanes, (const LaneWalkTask& task))
LAMELLA_LANE_FUNCTION(void, walk_stack_lanes, (const LaneWalkTask& task))
LAMELLA_LANE_FUNCTION(void, walk_layered_lanes, (const LaneWalkTask& task))
LAMELLA_LANE_FUNCTION(void, walk_bounded_lanes, (const LaneWalkTask& task))
LAMELLA_LANE_FUNCTION(void, aim_bounded_lanes, (const LaneWalkTask& task))

}  // namespace lamella
