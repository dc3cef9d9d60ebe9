#pragma once

#include <memory>
#include <optional>
#include <string>

#include "volume/grid_walk/grid_walk_task.h"
#include "volume/lanes/lane_setting.h"
#include "volume/result/walk_samples.h"
#include "volume/voxels/ray_table.h"
#include "volume/walk/incident_law.h"
#include "volume/walk/scorers.h"

namespace lamella {

/// Walks through a layer with a density grid on lanes, counted or kept where they leave. A walk is
/// a function of seed and index alone, and what walks are worth is added in their order.
class GridLaneRun {
 public:
  /// Why the walks of a stack with grids that send no light anywhere run in double, if they do; in
  /// words for a user. table: of the first layer's grid, if it has one.
  [[nodiscard]] static std::optional<std::string> why_not(const Stack& stack, const Plan& plan,
                                                          const GridRayTable* table);
  /// Counted walks of light from w_i, or nullptr where there is a reason. cells: none: energies
  /// alone.
  [[nodiscard]] static std::unique_ptr<GridLaneRun> make(const Stack& stack, const Plan& plan,
                                                         Direction incident, std::uint64_t seed,
                                                         const CellTargets* cells);

  /// The walks `from` to `to` (not included) of a batch. Throws MajorantError, NonFiniteError.
  void count(int batch, std::uint64_t from, std::uint64_t to, BatchTally& tally) const;
  /// What leaves of the walks `from` to `to` (not included), without lattices. law: with another
  /// than `fixed` every walk draws its w_i. Throws as `count`.
  [[nodiscard]] WalkSamples take(IncidentLaw law, std::uint64_t from, std::uint64_t to) const;

 private:
  struct Ends;

  GridLaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
              const CellTargets* cells, std::shared_ptr<const GridRayTable> table);
  /// Follows the walks of a task; returns their collisions. Throws as `count`.
  std::uint64_t follow(GridWalkTask& task, Ends& ends) const;
  /// Adds what the walks of a task, of one batch, are worth.
  template <int C>
  void add(const GridWalkTask& task, const Ends& ends, BatchTally& tally) const;

  std::shared_ptr<const GridRayTable> table_;
  LaneSetting<float> setting_;
  Direction incident_;
  Sampling sampling_;
  int channels_;
  GridWalkCount (*walk_)(const GridWalkTask&);
  GridWalkTask task_;  ///< what all tasks share
  std::optional<CellTargets> cells_;
};

}  // namespace lamella
