#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/result/tally.h"

namespace lamella {

/// Cosines of normals, in equal steps over [-1, 1].
inline constexpr int kNormalBins = 20;
/// Slices of a bed's profile, each half a radius high, from one radius above the topmost centres
/// downwards.
inline constexpr int kProfileSlices = 20;
inline constexpr double kProfileStep = 0.5;  ///< in radii
inline constexpr double kProfileTop = 1;     ///< in radii above z = 0

/// One slice of a bed, at z from `z_from` down to `z_to` [mm].
struct ProfileSlice {
  double z_from = 0, z_to = 0;
  Estimate packing;  ///< centres per volume times the volume of a sphere
  Estimate filled;   ///< share of the volume inside of grains
};

/// A statistical medium's normals fitted to those that light from above meets first, by maximum
/// likelihood: flakes with the distribution D show the light from w the normal m with the density
/// D(m) <w, m> / sigma(w). The error is from the scatter of fits to groups of realisations.
struct NormalFit {
  Estimate roughness;  ///< vMF: r in [0, 1]; SGGX: alpha of a surface about z, in [0.01, 1]
  std::array<double, kNormalBins> first_normals{};  ///< the fit's prediction of the measured ones
};

/// The quantities of explicit geometry that a medium has as well. Lengths in mm.
struct GrainMeasurement {
  std::uint64_t realisations = 0, rays = 0;

  // Beds, inside: at least a radius (two, of packed beds) away from both ends.
  Estimate filled;  ///< share of the volume inside of grains
  /// From the surface inwards: where centres crowd at the ends of a bed, light meets them first.
  /// Slices that reach below the bed are left out.
  std::vector<ProfileSlice> profile{};
  Estimate exposed;       ///< share of the grains' surface that lies in no other grain
  Estimate surface_area;  ///< exposed surface per volume outside of grains [1/mm]
  /// Exposed surface projected along w per volume outside of grains [1/mm], for w at the cosines
  /// 1, 0.5, 0: the extinction that light from w meets. Also its mean over all w, a quarter of the
  /// surface.
  std::array<Estimate, 3> projected_area;
  Estimate extinction;
  /// Share of the exposed surface per bin of the normal's cosine with z.
  std::array<Estimate, kNormalBins> normals;

  // The first grains that light from above meets, by directions with the density cos / pi.
  Estimate passed;                                  ///< share of that light that meets no grain
  std::array<Estimate, kNormalBins> first_normals;  ///< share of the rest per bin of the cosine
  NormalFit vmf, sggx;
};

/// Measures `realisations` realisations with `rays` rays and `rays` points each. Throws
/// GeometryError without Embree.
[[nodiscard]] GrainMeasurement measure_grains(const GrainGeometry& geometry, std::uint64_t seed,
                                              std::uint64_t realisations, std::uint64_t rays);

/// Media that a stack of explicit geometry can be replaced by.
enum class Equivalent { lambert_sphere, vmf_flake, sggx };

/// The stack of that medium over the same substrate. Its density is such that the mean projected
/// area is the extinction measured (beds), or that it passes as much light at normal incidence as
/// the filling factor leaves (micrograins). Beds that let less than 1e-3 of the light through
/// become half spaces. Throws std::invalid_argument where no medium of that kind can stand for the
/// grains: Lambert spheres for anything but Lambertian beds, flakes for dielectric grains.
[[nodiscard]] Stack equivalent_stack(const Stack& stack, const GrainMeasurement& measurement,
                                     Equivalent medium);

}  // namespace lamella
