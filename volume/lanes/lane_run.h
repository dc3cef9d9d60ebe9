#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volume/lanes/lane_setting.h"
#include "volume/lanes/lane_task.h"
#include "volume/lanes/lane_ways.h"
#include "volume/plan/plan.h"
#include "volume/result/estimator.h"
#include "volume/result/tally.h"
#include "volume/walk/scorers.h"

namespace lamella {

/// Why the walks of a stack run in the scalar double kernel, if they do; in words for a user. Where
/// float could not keep its promise (a relative bias below 1e-5), the answer is a reason, too.
[[nodiscard]] std::optional<std::string> why_not_lanes(const Stack& stack, const Plan& plan);
/// Why lanes have no kernel for a medium, or float is too coarse for it; depth: of its layer.
[[nodiscard]] std::optional<std::string> why_not_lane_medium(const Medium& medium, double depth);
/// The first question for next-event estimation at points, and in cells.
[[nodiscard]] std::optional<std::string> why_not_lanes_at(const Stack& stack, const Plan& plan,
                                                          const std::vector<Direction>& points);
[[nodiscard]] std::optional<std::string> why_not_lanes_in_cells(const Stack& stack,
                                                                const Plan& plan,
                                                                const CellGrid& grid);

/// By how many bits next-event terms of thinned walks, of which one counts for hundreds, are
/// rounded more coarsely than to 1 / kPointUnits, so that fixed point holds the largest.
[[nodiscard]] int coarser_bits_at_points(const Stack& stack, const Plan& plan);
[[nodiscard]] int coarser_bits_in_cells(const Stack& stack, const Plan& plan, const CellGrid& grid);
/// Through interfaces, to points or cells.
[[nodiscard]] int coarser_bits_along_ways(const Stack& stack, const Plan& plan);

/// The walks of one incident direction on lanes. Everything is counted in whole numbers, or in
/// fixed point, so that a batch's tally does not depend on how its walks were dealt out.
class LaneRun {
 public:
  /// Walks with the analog estimator's counts in cells, or with next-event estimates of them.
  LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed, int batches,
          const CellTargets& cells, Estimator estimator);
  /// Walks with next-event estimates of f at points; without any, energies alone.
  LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed, int batches,
          const std::vector<Direction>& points);

  /// The walks from, from + 1, ... to - 1 of a batch.
  struct Part {
    std::uint64_t from, to;
  };
  /// Runs one part of each of several neighbouring batches, `first` being the first of them, and
  /// brings their tallies up to date. Several batches share a run where walks are thinned: while a
  /// few long walks go on, walks of the next batch fill the other lanes. Different batches may run
  /// at the same time. Throws NonFiniteError.
  void run(int first, std::span<const Part> parts, std::span<BatchTally> tallies);

  [[nodiscard]] LaneUse use() const;

  /// The counts of a batch as bytes, and back; a tally alone cannot go on. Throws DamagedBytes
  /// where the bytes are those of other counts.
  [[nodiscard]] std::string save(int batch) const;
  void restore(int batch, std::string_view bytes);

 private:
  /// What lanes load and store: no vector of theirs straddles two cache lines.
  template <class T>
  using Aligned = std::vector<T, tbb::cache_aligned_allocator<T>>;

  struct Counts {
    std::vector<std::uint64_t> ends;
    std::vector<std::int64_t> weights, cells, shares, forced;
    Aligned<std::int64_t> targets;
    std::vector<std::int64_t> zero_coarse, zero_fine;  ///< per point: ZeroTerm
    Aligned<float> scratch;
    std::uint64_t lane_steps = 0, busy = 0, events = 0, reflections = 0, meetings = 0;
    [[nodiscard]] LaneSums sums() {
      return {.ends = ends.data(),
              .weights = weights.data(),
              .cells = cells.data(),
              .shares = shares.data(),
              .forced = forced.data(),
              .targets = targets.data()};
    }
  };
  /// The index of the first walk of a batch with a number that is not finite, if there is one.
  [[nodiscard]] std::optional<std::uint64_t> first_not_finite(LaneWalkTask task,
                                                              LaneBatch batch) const;
  LaneRun(LaneEstimate estimate, const Stack& stack, const Plan& plan, Direction incident,
          std::uint64_t seed, int batches);
  /// Whether the first flights are, see volume/lanes/lane_forced_flights.h.
  [[nodiscard]] bool forces_flights(const Stack& stack) const;
  void trace(const Stack& stack, const std::vector<Direction>& points);
  /// Next-event estimation through interfaces, by `ways_`.
  void aim_along_ways(Isa isa);
  struct Ways {
    std::vector<WayTables::Set> sets;
    std::vector<LaneWays> tables;  ///< theirs
  };
  /// The ways that walks of a batch take; counts what order 0 sends to points. None where all walks
  /// take the same.
  Ways ways_of(int batch, std::uint64_t from, std::uint64_t walks);
  /// The shift of a batch's lattice from a walk of the batch on.
  [[nodiscard]] std::uint32_t lattice_shift_of(int batch, std::uint64_t walk) const;
  /// Walks by end and order, those that cells count among them.
  [[nodiscard]] std::vector<std::uint64_t> all_ends(const Counts& counts) const;
  void to_tally(const Counts& counts, BatchTally& tally) const;
  void zero_to_tally(const Counts& counts, BatchTally& tally) const;
  void energies_to_tally(const Counts& counts, BatchTally& tally) const;
  /// What walks of one channel count by their order, for stacks of one albedo in colour.
  void tabulate_weights(int channel);

  /// Rows of ends, and slots of orders.
  [[nodiscard]] int rows() const { return bounded_ ? kEndRows<true> : kEndRows<false>; }
  [[nodiscard]] int slots() const { return bounded_ ? kZeroSlot + 1 : kTallyOrders; }

  LaneSetting<float> setting_;
  Sampling sampling_;
  bool bounded_;  ///< there are interfaces
  Thinning thinning_;
  void (*walk_)(const LaneWalkTask&);
  LaneWalkTask task_;
  Direction incident_;
  CellTargets cells_;
  std::vector<double> inverse_mu_;  // per point
  std::optional<WayTables> ways_;
  std::optional<WayTables::Set> common_ways_;  ///< where no way is random
  Aligned<float> point_x_, point_y_, point_z_, rate_, beyond_, rate_by_point_, beyond_by_point_;
  Aligned<float> column_cos_, column_sin_;
  std::vector<float> event_weight_;
  std::vector<std::int64_t> end_weight_;
  std::vector<Counts> counts_;
};

}  // namespace lamella
