#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "phase/medium/medium.h"

namespace lamella {

/// A distribution of flakes' normals that is symmetric about an axis.
struct AxialNormals {
  Direction axis;                         ///< unit
  std::function<double(double)> density;  ///< D [1/sr] at an angle in [0, pi] from the axis
  double width = 1;           ///< [radians] D is smooth over angles that are small against this,
  std::vector<double> peaks;  ///< and over wider ones away from these angles
  bool mirrors = false;       ///< or Lambertian flakes
  bool is_even = false;       ///< D is the same at an angle and at pi less it
};

/// Nothing for particles and for flakes whose distribution has no such axis (SGGX with three
/// distinct eigenvalues).
[[nodiscard]] std::optional<AxialNormals> axial_normals(const Medium& medium);

/// Of flakes, with an axis of symmetry or without one: the angle over which D is smooth.
[[nodiscard]] double width_of_normals(const Medium& medium);

/// Whether the medium consists of flakes.
[[nodiscard]] bool has_normals(const Medium& medium);

}  // namespace lamella
