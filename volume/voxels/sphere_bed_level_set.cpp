#include "volume/voxels/sphere_bed_level_set.h"

#include <cmath>
#include <vector>

#include "phase/grains/grain_geometry.h"
#include "phase/math/direction.h"
#include "volume/voxels/vdb_file.h"

namespace lamella {
namespace {

// The spheres of a bed as the tracer places them that reach into a cube inside of it by more than
// `margin`, with their periodic images; the cube's lowest corner becomes the origin.
std::vector<Direction> spheres_in_cube(const GrainGeometry& bed, double margin, std::uint64_t seed,
                                       std::uint64_t realisation, std::uint64_t& count) {
  const double edge = bed.tile, floor = -bed.thickness + margin;
  std::vector<Direction> out;
  const auto reaches = [&](double at) { return at > -margin && at < edge + margin; };
  for (const Direction& c : place_grains(bed, seed, realisation)) {
    ++count;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const Direction image{c.x + dx * edge, c.y + dy * edge, c.z - floor};
        if (reaches(image.x) && reaches(image.y)) out.push_back(image);
      }
  }
  return out;
}

Estimate mean_of(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  double mean = 0, variance = 0;
  for (const double v : values) mean += v / n;
  for (const double v : values) variance += (v - mean) * (v - mean) / (n - 1);
  return {mean, std::sqrt(variance / n)};
}

}  // namespace

SphereBedCheck check_sphere_bed(double radius, double packing, int realisations,
                                int voxels_per_radius, std::uint64_t seed) {
  constexpr double kEdge = 12;  // in radii
  const double edge = kEdge * radius, voxel = radius / voxels_per_radius;
  const double sphere = 4 * kPi / 3 * radius * radius * radius;
  const double number = packing / sphere;
  const double margin = radius + 4 * voxel;
  const GrainGeometry bed{.placement = GrainPlacement::sphere_bed,
                          .radius = radius,
                          .packing = packing,
                          .thickness = edge + 2 * margin,
                          .tile = edge};
  std::vector<double> volumes, areas;
  SphereBedCheck check;
  check.realisations = realisations;
  for (int k = 0; k < realisations; ++k) {
    const std::vector<Direction> spheres = spheres_in_cube(bed, margin, seed, k, check.spheres);
    const LevelSetMeasure m = measure_level_set(spheres, radius, voxel, {edge, edge, edge});
    volumes.push_back(m.volume_fraction);
    areas.push_back(m.area_density);
  }
  check.volume_fraction = mean_of(volumes);
  check.area_density = mean_of(areas);
  const auto volume_at = [&](double r) { return -std::expm1(-number * 4 * kPi / 3 * r * r * r); };
  const auto area_at = [&](double r) {
    return number * 4 * kPi * r * r * std::exp(-number * 4 * kPi / 3 * r * r * r);
  };
  check.expected_volume_fraction = volume_at(radius);
  check.expected_area_density = area_at(radius);
  // The union of spheres of radius r + d is the level set at d: means over the kernel.
  constexpr int kSteps = 400;
  const double width = 1.5 * voxel;
  for (int k = 0; k < kSteps; ++k) {
    const double t = 2 * (k + 0.5) / kSteps - 1;
    const double weight = (1 + std::cos(kPi * t)) / kSteps;
    check.blurred_volume_fraction += weight * volume_at(radius + t * width);
    check.blurred_area_density += weight * area_at(radius + t * width);
  }
  return check;
}

}  // namespace lamella
