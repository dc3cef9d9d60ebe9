#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "phase/math/vec3.h"
#include "phase/parameters/parameters.h"

namespace lamella {

/// How grains are placed, or what stands in their place.
enum class GrainPlacement {
  sphere_bed,         ///< equal spheres, centres a Poisson process: they may overlap
  packed_sphere_bed,  ///< equal spheres by random sequential addition: none overlaps another
  micrograins,        ///< upper halves of ellipsoids on the plane z = 0, centres a Poisson process
  height_field        ///< no grains: a Gaussian random surface about the plane z = 0
};

/// How a grain reflects.
enum class GrainSurface {
  lambert,     ///< Lambert's law
  mirror,      ///< mirrored, with Schlick's factor of f0
  dielectric,  ///< Fresnel's reflection over a Lambertian base
  conductor    ///< a mirror, by the name that micrograins have for it
};

/// By its name: lambert, mirror, dielectric or conductor.
[[nodiscard]] GrainSurface grain_surface_from(std::string_view name);

/// Explicit micro-geometry that stands alone on a stack's substrate: grains in a square tile that
/// repeats in x and y. Lengths in mm.
///
/// Beds: centres in [-thickness, 0], so spheres stand out by a radius at both sides. Micrograins:
/// half ellipsoids of horizontal radius `radius` and height beta * radius. Height fields: heights
/// are Gaussian with the autocorrelation h^2 exp(-r^2 / radius^2), so that slopes are those of
/// Beckmann's facets of roughness alpha = 2 h / radius; triangles between nodes on a square grid.
struct GrainGeometry {
  GrainPlacement placement = GrainPlacement::sphere_bed;
  GrainSurface surface = GrainSurface::lambert;
  double radius = 1;   ///< in (0, infinity); height fields: the correlation length
  double packing = 0;  ///< number density times the volume of a sphere; beds only
  /// Beds: range of the centres; micrograins: their height; height fields: 16 standard deviations.
  double thickness = 0;
  double tau0 = 0;   ///< filling factor in [0, 1); micrograins only
  double beta = 1;   ///< height over radius in (0, 1]; 1 for beds
  double tile = 1;   ///< lateral period, at least 4 radii
  double ior = 1.5;  ///< of a dielectric, above 1
  double alpha = 0;  ///< Beckmann's, of the slopes of the triangles; height fields only
  int nodes = 0;     ///< along a side of the tile; height fields only
  /// Packed beds: cut from a packing without ends, so that the density is the same at every depth.
  /// Otherwise the centres fill [-thickness, 0] between walls, and crowd at them.
  bool cut = false;

  [[nodiscard]] bool is_bed() const {
    return placement == GrainPlacement::sphere_bed ||
           placement == GrainPlacement::packed_sphere_bed;
  }
  [[nodiscard]] bool is_height_field() const { return placement == GrainPlacement::height_field; }
  /// The power of two next below the radius [mm], and the same geometry with lengths in that unit:
  /// its radius lies in [1, 2), so that squares and cubes of lengths are finite and not 0 at any
  /// radius. Results in this unit are the same, bit by bit, at radii that differ by powers of two.
  [[nodiscard]] double length_unit() const;
  [[nodiscard]] GrainGeometry in_units() const;
  /// Centres per volume [1/mm^3] of a bed, per area [1/mm^2] of micrograins; triangles per area.
  [[nodiscard]] double number_density() const;
  /// Mean number of grains in a tile; of triangles in a height field's.
  [[nodiscard]] double expected_count() const;
  /// Height of the box that a packed bed is packed in. The box of a cut bed is periodic and taller
  /// by eight radii, a distance at which centres are no longer correlated.
  [[nodiscard]] double packed_height() const { return cut ? thickness + 8 * radius : thickness; }
  /// Heights between which light meets grains: it enters at `top`.
  [[nodiscard]] double top() const {
    return is_bed() ? radius : is_height_field() ? thickness / 2 : beta * radius;
  }
  [[nodiscard]] double bottom() const {
    return is_bed() ? -thickness - radius : is_height_field() ? -thickness / 2 : 0;
  }
};

/// More grains than a tile may hold, by any placement.
inline constexpr double kMostGrains = 4e6;

/// Random sequential addition did not reach the packing that was asked for.
struct PackingError : std::runtime_error {
  PackingError(double asked, double reached);
};

/// Centres of the grains of one realisation, x and y in [0, tile). The same for equal arguments.
/// Poisson placements: their number is Poisson's, and beds come sorted from the top. Packed beds:
/// the number that the packing asks for (cut beds: in the taller box), its fraction rounded up or
/// down at random. Throws PackingError.
[[nodiscard]] std::vector<Direction> place_grains(const GrainGeometry& geometry, std::uint64_t seed,
                                                  std::uint64_t realisation);

/// A geometry as stack files and `lamella media` know it.
struct GeometryInfo {
  std::string name;
  GrainPlacement placement;
  std::string doc;
  std::string source;
  std::vector<ParameterInfo> parameters;  ///< its own keys, beside the albedo
};

[[nodiscard]] const std::vector<GeometryInfo>& geometries();

/// The entry with that name, or nullptr.
[[nodiscard]] const GeometryInfo* find_geometry(std::string_view name);

/// Builds the geometry from checked parameters and completes them. Throws ParameterError.
[[nodiscard]] GrainGeometry make_geometry(const GeometryInfo& info, Parameters& parameters);

}  // namespace lamella
