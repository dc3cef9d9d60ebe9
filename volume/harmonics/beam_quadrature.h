#pragma once

#include <vector>

#include "phase/math/direction.h"

namespace lamella {

/// Quadrature over the sphere about the direction straight on of a beam, where phase functions of
/// mirror flakes jump and others peak: in polar coordinates about it, each ray of constant azimuth
/// cut where it crosses the horizon, with points that crowd at the cut like t^2 and at the beam.
struct BeamQuadrature {
  std::vector<Direction> directions;
  std::vector<double> weights;  ///< [sr]

  /// along: unit, where the light goes. points: of each part of a ray; rays: their number
  /// about a steep beam, more where it grazes. Harmonics of degree 12 are integrated to 1e-9 by 40
  /// points and 96 rays at any cosine from 1e-6 on.
  /// cuts: positive cosines that rays are cut at, too, on either side of the horizon.
  /// is_even: of functions that are the same at y and -y, by the rays of one side with twice their
  /// weight; `along` lies in the plane between them.
  BeamQuadrature(Direction along, int points, int rays, const std::vector<double>& cuts = {},
                 bool is_even = false);
};

}  // namespace lamella
