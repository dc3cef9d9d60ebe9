#include "volume/voxels/depth_profile.h"

#include <algorithm>
#include <cmath>

#include "phase/medium/media.h"

namespace lamella {
namespace {

double slice_mean(const Voxels& voxels, int z) {
  const VoxelIndex n = voxels.extent().voxels;
  double sum = 0;
  for (int y = 0; y < n[1]; ++y)
    for (int x = 0; x < n[0]; ++x) sum += voxels.density.at({x, y, z})[0];
  return sum / (static_cast<double>(n[0]) * n[1]);
}

// S of an axial SGGX medium from its areas along and across the axis.
std::array<double, 6> axial_matrix(double along, double across, Direction n) {
  const double a = along * along, c = across * across, d = a - c;
  return {c + d * n.x * n.x, c + d * n.y * n.y, c + d * n.z * n.z,
          d * n.x * n.y,     d * n.x * n.z,     d * n.y * n.z};
}

// Density-weighted sums over a slice of what its voxels hold.
struct SliceSums {
  double weight = 0, roughness = 0;
  std::array<double, 6> matrix{};
  Direction normal{0, 0, 0};
  Rgb albedo{0};
};

SliceSums sums_of(const Layer& layer, const DensityGrid& grid, int z) {
  const VoxelIndex n = grid.extent().voxels;
  SliceSums sums;
  const bool sggx = layer.medium_name == "sggx";
  const Direction own =
      layer.parameters.has("axis") ? layer.parameters.vector("axis") : Direction{0, 0, 1};
  // Areas along and across the axis, per entry of the palette.
  std::vector<std::array<double, 2>> areas;
  const Direction palette_axis = grid.has_orientation() ? Direction{0, 0, 1} : own;
  for (const Medium& medium : grid.palette())
    areas.push_back({sigma(medium, palette_axis), sigma(medium, frame_around(palette_axis).s)});
  VoxelIndex i{0, 0, z};
  for (i[1] = 0; i[1] < n[1]; ++i[1])
    for (i[0] = 0; i[0] < n[0]; ++i[0]) {
      const double rho = grid.density(i);
      if (!(rho > 0)) continue;
      sums.weight += rho;
      if (grid.has_albedo()) {
        const auto a = grid.albedo(i);
        sums.albedo = sums.albedo + Rgb(rho * a[0], rho * a[1], rho * a[2]);
      }
      if (!grid.is_local()) continue;
      const Direction axis = grid.has_orientation() ? normalized(grid.axis(i)) : own;
      const int index = grid.palette_index(i);
      if (sggx) {
        const auto s = axial_matrix(areas[index][0], areas[index][1], axis);
        for (int k = 0; k < 6; ++k) sums.matrix[k] += rho * s[k];
      } else {
        sums.normal = sums.normal + rho * axis;
        sums.roughness += rho * (grid.has_roughness() ? grid.voxels().roughness->at(i)[0] : 0);
      }
    }
  return sums;
}

Layer layer_of(const Layer& from, Parameters parameters, Rgb albedo, double density) {
  Layer layer = from;
  layer.grid.reset();
  layer.medium = find_medium(from.medium_name)->make(parameters);
  layer.parameters = std::move(parameters);
  layer.albedo = albedo;
  layer.density = density;
  return layer;
}

bool same_but_thickness(const Layer& a, const Layer& b) {
  return a.density == b.density && a.albedo == b.albedo && a.parameters.all() == b.parameters.all();
}

}  // namespace

LateralContrast lateral_contrast(const DensityGrid& grid) {
  const VoxelIndex n = grid.extent().voxels;
  std::vector<double> columns(static_cast<std::size_t>(n[0]) * n[1]);
  double squares = 0, total = 0, filled = 0;
  for (int z = 0; z < n[2]; ++z) {
    const double mean = slice_mean(grid.voxels(), z);
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        const double rho = grid.density({x, y, z});
        squares += (rho - mean) * (rho - mean);
        total += rho;
        filled += rho > 0;
        columns[static_cast<std::size_t>(y) * n[0] + x] += rho;
      }
  }
  const double count = static_cast<double>(columns.size()) * n[2];
  LateralContrast out;
  out.filled = filled / count;
  if (!(total > 0)) return out;
  out.voxel = std::sqrt(squares / count) / (total / count);
  const double mean = total / static_cast<double>(columns.size());
  double variance = 0;
  for (const double c : columns) variance += (c - mean) * (c - mean);
  out.column = std::sqrt(variance / static_cast<double>(columns.size())) / mean;
  return out;
}

std::vector<Layer> depth_profile(const Layer& layer, const DensityGrid& grid) {
  const VoxelIndex n = grid.extent().voxels;
  std::vector<Layer> out;
  for (int z = n[2] - 1; z >= 0; --z) {
    const double density = layer.density * slice_mean(grid.voxels(), z);
    Rgb albedo = layer.albedo;
    Parameters parameters = layer.parameters;
    if (density > 0 && (grid.is_local() || grid.has_albedo())) {
      const SliceSums sums = sums_of(layer, grid, z);
      const double w = 1 / sums.weight;
      if (grid.has_albedo())
        for (int c = 0; c < 3; ++c) albedo[c] = std::min(1.0, albedo[c] * sums.albedo[c] * w);
      if (grid.is_local() && layer.medium_name == "sggx") {
        Parameters own;
        for (const char* key : {"flake", "f0"})
          if (parameters.has(key)) own.set(key, parameters.at(key));
        std::vector<double> matrix;
        for (const double s : sums.matrix) matrix.push_back(s * w);
        own.set("matrix", matrix);
        parameters = std::move(own);
      } else if (grid.is_local()) {
        if (dot(sums.normal, sums.normal) > 0) {
          const Direction m = normalized(sums.normal);
          parameters.set("axis", std::vector<double>{m.x, m.y, m.z});
        }
        if (grid.has_roughness()) parameters.set("roughness", sums.roughness * w);
      }
    }
    Layer next = layer_of(layer, std::move(parameters), albedo, density);
    next.thickness = layer.thickness / n[2];
    if (!out.empty() && same_but_thickness(out.back(), next))
      out.back().thickness += next.thickness;
    else
      out.push_back(std::move(next));
  }
  return out;
}

Stack homogenised(const Stack& stack,
                  const std::vector<std::shared_ptr<const DensityGrid>>& grids) {
  Stack out = stack;
  out.layers.clear();
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    if (k < grids.size() && grids[k]) {
      for (Layer& layer : depth_profile(stack.layers[k], *grids[k]))
        out.layers.push_back(std::move(layer));
    } else {
      out.layers.push_back(stack.layers[k]);
      out.layers.back().grid.reset();
    }
  }
  return out;
}

Voxels with_contrast(const Voxels& voxels, double factor) {
  Voxels out = voxels;
  for (int z = 0; z < voxels.extent().voxels[2]; ++z) {
    const double mean = slice_mean(voxels, z);
    VoxelIndex i{0, 0, z};
    for (i[1] = 0; i[1] < voxels.extent().voxels[1]; ++i[1])
      for (i[0] = 0; i[0] < voxels.extent().voxels[0]; ++i[0])
        out.density.set(i, {static_cast<float>(mean + factor * (voxels.density.at(i)[0] - mean))});
  }
  return out;
}

}  // namespace lamella
