#pragma once

#include <cstdint>

#include "volume/result/tally.h"

namespace lamella {

/// Beds of overlapping equal spheres at random (Poisson's), as level sets, against two known
/// results: the share 1 - exp(-packing) of space is inside, packing being number density times
/// sphere volume, and a volume holds the surface 3 packing / radius exp(-packing) [1/mm], the part
/// of all spheres' that no other one covers.
struct SphereBedCheck {
  Estimate volume_fraction, area_density;  ///< means over realisations
  double expected_volume_fraction = 0, expected_area_density = 0;
  /// The known results blurred by the level set's kernels: the limits of the means for infinitely
  /// many realisations.
  double blurred_volume_fraction = 0, blurred_area_density = 0;
  int realisations = 0;
  std::uint64_t spheres = 0;  ///< of all realisations
};

/// radius [mm], packing: positive. Each realisation is a cube of 12 radii, periodic in x and y,
/// within a bed as `place_grains` makes it; a radius is `voxels_per_radius` voxels. Throws
/// GridFileError in a build without OpenVDB.
[[nodiscard]] SphereBedCheck check_sphere_bed(double radius, double packing, int realisations,
                                              int voxels_per_radius, std::uint64_t seed);

}  // namespace lamella
