#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volume/lane_walk.h"
#include "volume/plan.h"
#include "volume/scorers.h"
#include "volume/tally.h"

namespace lamella {

/// Why the walks of a stack run in the scalar double kernel, if they do; in words for a user. Lanes
/// cover one grey layer of one medium. Where float could not keep its promise (a relative bias
/// below 1e-5), the answer is a reason, too.
[[nodiscard]] std::optional<std::string> why_not_lanes(const Stack& stack, const Plan& plan);
/// Likewise for next-event estimation at points.
[[nodiscard]] std::optional<std::string> why_not_lanes_at(const Stack& stack, const Plan& plan,
                                                          const std::vector<Direction>& points);

/// The walks of one incident direction on lanes. Everything is counted in whole numbers (or, next
/// event, in fixed point), so that a batch's tally does not depend on how its walks were dealt out.
class LaneRun {
 public:
  /// Walks with energies alone, or with the analog estimator's counts in cells.
  LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed, int batches,
          const CellTargets* cells);
  /// Walks with next-event estimates of f at points.
  LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed, int batches,
          const std::vector<Direction>& points);

  /// The walks from, from + 1, ... to - 1 of a batch; updates the tally to all its walks so far.
  /// Batches may run at the same time. Throws NonFiniteError.
  void run(int batch, std::uint64_t from, std::uint64_t to, BatchTally& tally);

  [[nodiscard]] double occupancy() const;

 private:
  struct Counts {
    std::vector<std::uint64_t> ends, cells;
    std::vector<std::int64_t> points;
    std::uint64_t lane_steps = 0, busy = 0;
  };
  void set_up(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed);
  void to_tally(const Counts& counts, BatchTally& tally) const;

  void (*walk_)(const LaneWalkTask&);
  LaneWalkTask task_;
  Direction incident_;
  double albedo_ = 1;
  double chance_ = 1;  // of the first collision where it is forced
  const CellTargets* cells_ = nullptr;
  std::vector<double> inverse_mu_;                         // per point
  std::vector<float> point_x_, point_y_, point_z_, rate_;  // padded
  std::vector<float> marginals_;
  std::vector<Counts> counts_;
};

}  // namespace lamella
