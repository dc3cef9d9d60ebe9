#pragma once

#include <functional>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// f mu_i of one outgoing direction, integrated over the hemisphere of w_i on cells that are small
/// where the lobe is narrow.
///
/// Domain: f the same for w_i and its mirror image in the plane of w_o and the normal (surfaces
/// without a preferred azimuth), finite or growing like 1 / mu_i at most. Error: below
/// kLobeTolerance of the integral where `resolved`; the estimate is the change under the last
/// halving of every cell, which leaves less than it changed.
///
/// Cells are rectangles in radius and azimuth of the half disc that Lambert's azimuthal projection
/// makes of the hemisphere: radius sqrt(2) sin(theta_i / 2), equal areas for equal solid angles,
/// shapes kept within 2 : 1. Cells about the mirror direction of w_o and about w_o itself are
/// halved down to kSeedShare of mu_o before any change is judged, so that a narrow peak there is
/// found.
struct LobeCells {
  struct Cell {
    double x, y, size;  ///< middle and longer side, in units of the disc's radius
    /// The error of the cell's integral if f were taken at its middle and mu_i integrated: the
    /// largest of the channels.
    double middle_error;
  };
  Rgb energy;  ///< integral of f mu_i dw_i over the hemisphere
  bool resolved = true;
  std::vector<Cell> cells;  ///< cover the half disc y > 0
};

inline constexpr double kLobeTolerance = 5e-4;
inline constexpr double kSeedShare = 0.05;

/// f [1/sr] as a function of w_i; w_o = (sqrt(1 - mu_o^2), 0, mu_o), mu_o in (0, 1].
[[nodiscard]] LobeCells lobe_cells(const std::function<Rgb(Direction wi)>& f, double mu_o);

/// A direction above the surface on Lambert's disc, and back.
struct DiscPoint {
  double x, y;
};
[[nodiscard]] DiscPoint on_lambert_disc(Direction w);
[[nodiscard]] Direction from_lambert_disc(DiscPoint p);

}  // namespace lamella
