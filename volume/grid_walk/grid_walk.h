#pragma once

#include <memory>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/plan/plan.h"
#include "volume/result/estimator.h"
#include "volume/result/tally.h"
#include "volume/voxels/density_grid.h"
#include "volume/walk/departures.h"
#include "volume/walk/scorers.h"
#include "volume/walk/walk_batches.h"

namespace lamella {

/// Directions nearer to the horizon than this cosine are refused with a grid: in the limit mu -> 0
/// a way through empty voxels has no end.
inline constexpr double kGridGrazing = 1e-6;

/// A layer as the walk through grids sees it. Lengths in mm: where the density varies laterally, a
/// homogeneous layer, too, moves the light sideways.
struct GridWalkLayer {
  const Medium* medium;
  const DensityGrid* grid;  ///< nullptr: homogeneous
  double thickness, density;
  std::array<double, 3> albedo, f0;
  bool fresnel;
};

/// A stack with grids as the walk sees it: layers that have thickness, from the top.
struct GridWalkStack {
  /// Throws std::invalid_argument if no tile holds whole periods of all grids.
  GridWalkStack(const Stack& stack, const Plan& plan);

  std::vector<GridWalkLayer> layers;
  double tile_x = 1, tile_y = 1;  ///< [mm], the period of all grids together
  bool has_substrate;
  std::array<double, 3> substrate_albedo;
  std::uint64_t max_order;
  std::vector<std::shared_ptr<const DensityGrid>> owned;
};

/// The smallest length that holds whole numbers, at most 1000, of every period; throws
/// std::invalid_argument with the periods if there is none.
[[nodiscard]] double common_period(const std::vector<double>& periods);

/// What the batches of a simulation with grids run: walks `from` to `to` (not included) of a batch,
/// and the instruction set that follows them.
struct GridRunner {
  RunBatch run;
  Isa isa = Isa::scalar;
};
/// The light enters uniformly over the tile and counts wherever it leaves: f is the tile's mean.
/// targets: cells; points: f at points instead, next-event (none: energies alone).
[[nodiscard]] GridRunner grid_runner(const Stack& stack, const Plan& plan, Direction incident,
                                     std::uint64_t seed, Estimator estimator,
                                     const CellTargets& targets,
                                     const std::vector<Direction>* points,
                                     std::vector<BatchTally>& batches);

/// Throws std::invalid_argument, with the direction's name `what`, for |mu| below kGridGrazing.
void check_beside_grids(const char* what, Direction w);

/// The same walks, one by one; |mu| of w_i is at least kGridGrazing.
[[nodiscard]] FollowWalk grid_follower(const Stack& stack, const Plan& plan, std::uint64_t seed);

}  // namespace lamella
