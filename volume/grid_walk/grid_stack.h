#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/plan/plan.h"
#include "volume/voxels/density_grid.h"

namespace lamella {

/// Directions nearer to the horizon than this cosine are refused with a grid: in the limit mu -> 0
/// a way through empty voxels has no end.
inline constexpr double kGridGrazing = 1e-6;

/// Throws std::invalid_argument, with the direction's name `what`, for |mu| below kGridGrazing.
void check_beside_grids(const char* what, Direction w);

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

}  // namespace lamella
