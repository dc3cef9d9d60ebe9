#include "volume/sphere_bed_level_set.h"

#include <cmath>
#include <vector>

#include "phase/direction.h"
#include "phase/random.h"
#include "volume/vdb_file.h"

namespace lamella {
namespace {

// Spheres of a periodic cube, with the images that reach into it by more than `margin`.
std::vector<Direction> poisson_spheres(double edge, double mean_count, double margin,
                                       RandomStream& stream, std::uint64_t& count) {
  std::vector<Direction> out;
  for (double arrived = stream.exponential(); arrived < mean_count;
       arrived += stream.exponential()) {
    ++count;
    const double x = edge * stream.uniform(), y = edge * stream.uniform();
    const Direction c{x, y, edge * stream.uniform()};
    const auto reaches = [&](double at) { return at > -margin && at < edge + margin; };
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const Direction image{c.x + dx * edge, c.y + dy * edge, c.z + dz * edge};
          if (reaches(image.x) && reaches(image.y) && reaches(image.z)) out.push_back(image);
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
  std::vector<double> volumes, areas;
  SphereBedCheck check;
  check.realisations = realisations;
  for (int k = 0; k < realisations; ++k) {
    RandomStream stream(seed, k, StreamPurpose::model);
    const std::vector<Direction> spheres = poisson_spheres(
        edge, number * edge * edge * edge, radius + 4 * voxel, stream, check.spheres);
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
