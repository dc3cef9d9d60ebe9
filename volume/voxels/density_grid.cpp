#include "volume/voxels/density_grid.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>

#include "phase/medium/media.h"
#include "volume/voxels/grid_generators.h"
#include "volume/voxels/vdb_file.h"

namespace lamella {
namespace {

constexpr int kPaletteSize = 256;

[[noreturn]] void refuse(const Layer& layer, const std::string& found, const std::string& allowed) {
  throw std::invalid_argument(fmt::format("{}: key \"grid\": {}: {}; allowed: {}",
                                          layer.grid->where, layer.grid->file, found, allowed));
}

// The layer's medium with some of its parameters replaced.
Medium remade(const Layer& layer, std::optional<double> roughness, bool axis_along_z) {
  Parameters p = layer.parameters;
  if (roughness) p.set("roughness", *roughness);
  if (axis_along_z) p.set("axis", std::vector<double>{0, 0, 1});
  return find_medium(layer.medium_name)->make(p);
}

// What the layer wants of its .vdb file.
VdbRequest request_of(const Layer& layer) {
  const GridReference& grid = *layer.grid;
  VdbRequest request;
  for (std::size_t k = 0; k < grid.names.size(); ++k)
    if (!grid.names[k].empty()) {
      request.names[k] = grid.names[k];
      request.required[k] = true;
    }
  request.voxels = grid.voxels;
  request.first_voxel = grid.first_voxel;
  request.size = Vec3<double>{grid.size_x, grid.size_y, layer.thickness};
  return request;
}

// Equal for equal files and requests.
std::string description(const Layer& layer) {
  const VdbRequest r = request_of(layer);
  std::string text = layer.grid->folder + '\n' + layer.grid->file;
  for (std::size_t k = 0; k < r.names.size(); ++k)
    text += fmt::format("\n{}{}", r.required[k] ? '+' : '-', r.names[k]);
  const VoxelIndex n = r.voxels.value_or(VoxelIndex{});
  return text + fmt::format("\n{} {} {} {} {} {} {} {} {}", n[0], n[1], n[2], r.first_voxel[0],
                            r.first_voxel[1], r.first_voxel[2], r.size->x, r.size->y, r.size->z);
}

bool is_particle(const Layer& layer) { return !traits(layer.medium).has_axis; }

}  // namespace

DensityGrid::DensityGrid(const Layer& layer, std::shared_ptr<const Voxels> voxels,
                         MajorantCells cells, std::string extent_source,
                         std::vector<std::string> warnings)
    : voxels_(std::move(voxels)),
      extent_source_(std::move(extent_source)),
      warnings_(std::move(warnings)),
      extent_(voxels_->extent()),
      layer_density_(layer.density) {
  const VoxelIndex n = extent_.voxels;
  voxel_size_ = {layer.grid->size_x / n[0], layer.grid->size_y / n[1], layer.thickness / n[2]};
  if (voxels_->albedo && !layer.grid->white) {
    for_each_voxel(extent_, [&](VoxelIndex i) {
      const auto a = voxels_->albedo->at(i);
      albedo_ = albedo_ || a != std::array<float, 3>{1, 1, 1};
      grey_ = grey_ && a[0] == a[1] && a[1] == a[2];
    });
  }
  make_axes(layer);
  make_palette(layer);
  MajorantTable table = majorant_table(
      {voxels_->density, axis_, index_, voxel_size_, layer_density_, two_sided_}, cells);
  cells_ = std::move(table.cells);
  cones_ = std::move(table.cones);
}

void DensityGrid::make_axes(const Layer& layer) {
  if (!voxels_->orientation || is_particle(layer)) return;  // particles have no axis
  if (!layer.parameters.has("axis"))
    refuse(layer,
           layer.parameters.has("matrix")
               ? "found a grid \"orientation\", but the medium is given by a matrix"
               : fmt::format("found a grid \"orientation\", but {} has no key \"axis\" to turn",
                             layer.medium_name),
           layer.parameters.has("matrix") ? "shape, roughness and axis, or no such grid"
                                          : "a medium with an axis, or no such grid");
  const Direction own = layer.parameters.vector("axis");
  axis_.emplace(extent_);
  axis_->fill({0, 0, 0}, extent_.voxels,
              {static_cast<float>(own.x), static_cast<float>(own.y), static_cast<float>(own.z)});
  for_each_voxel(extent_, [&](VoxelIndex i) {
    const auto& given = voxels_->orientation->at(i);
    const double largest = std::max({std::abs(given[0]), std::abs(given[1]), std::abs(given[2])});
    if (largest == 0) return;
    const Direction v =
        normalized(Direction{given[0] / largest, given[1] / largest, given[2] / largest});
    axis_->set(i, {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
  });
}

void DensityGrid::make_palette(const Layer& layer) {
  if (voxels_->roughness) {
    if (!layer.parameters.has("roughness"))
      refuse(layer,
             fmt::format("found a grid \"roughness\", but {} is not given by its roughness",
                         layer.medium_name),
             "an sggx or vmf_flake layer with the key roughness, or no such grid");
    const double own = layer.parameters.number("roughness");
    const ParameterInfo& range = *find(find_medium(layer.medium_name)->parameters, "roughness");
    std::set<double> found;
    const auto roughness_of = [&](VoxelIndex i) {
      const float given = voxels_->roughness->at(i)[0];
      return given > 0 ? std::max<double>(given, range.min) : own;
    };
    for_each_voxel(extent_, [&](VoxelIndex i) {
      if (density(i) > 0) found.insert(roughness_of(i));
    });
    if (found.empty()) found.insert(own);
    // Each value for itself if they are few, else levels at equal steps.
    const double low = *found.begin(), high = *found.rbegin();
    std::vector<double> levels(found.begin(), found.end());
    if (levels.size() > kPaletteSize) {
      levels.clear();
      for (int k = 0; k < kPaletteSize; ++k)
        levels.push_back(low + (high - low) * k / (kPaletteSize - 1));
      roughness_error_ = (high - low) / (2 * (kPaletteSize - 1));
    }
    for (const double r : levels) palette_.push_back(remade(layer, r, has_orientation()));
    index_.emplace(extent_);
    for_each_voxel(extent_, [&](VoxelIndex i) {
      if (!(density(i) > 0)) return;
      const double r = roughness_of(i);
      auto above = std::lower_bound(levels.begin(), levels.end(), r);
      if (above == levels.end()) --above;
      if (above != levels.begin() && r - *(above - 1) < *above - r) --above;
      index_->set(i, {static_cast<float>(above - levels.begin())});
    });
  } else {
    palette_.push_back(has_orientation() ? remade(layer, std::nullopt, true) : layer.medium);
  }
  const Medium& medium = palette_.back();
  const bool one_sided = !traits(medium).two_sided;
  two_sided_ = !one_sided;
  // sigma falls or rises all the way from the axis to the equator (SGGX), or to the other pole
  // (vMF); SGGX's rises with the roughness everywhere, so that the roughest of a cell bounds it.
  largest_along_axis_ = lamella::sigma(medium, {0, 0, 1}) >= lamella::sigma(medium, {1, 0, 0});
  // vMF's sigma is not monotone in the roughness; it never exceeds 1.
  if (one_sided && has_roughness()) bound_everywhere_ = 1;
}

DensityGrid::CellCount DensityGrid::count_cells() const {
  CellCount count;
  for_each_in_box({}, extent_.blocks(), 1, [&](VoxelIndex b) {
    const MajorantCell& c = cell({b[0] * kBlockVoxels, b[1] * kBlockVoxels, b[2] * kBlockVoxels});
    const int mask = (1 << c.level) - 1;
    ++count.blocks;
    count.empty_blocks += c.density == 0;
    count.cells += ((b[0] | b[1] | b[2]) & mask) == 0;
  });
  return count;
}

std::vector<std::shared_ptr<const DensityGrid>> load_grids(const Stack& stack,
                                                           MajorantCells cells) {
  std::vector<std::shared_ptr<const DensityGrid>> grids(stack.layers.size());
  struct Read {
    std::shared_ptr<const Voxels> voxels;
    std::string extent_source;
    std::vector<std::string> warnings;
  };
  // What is read, and how, tells files apart: two layers may take different grids of one.
  std::map<std::string, Read> files;
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    if (!layer.grid || !(layer.depth() > 0)) continue;
    const GridReference& grid = *layer.grid;
    const auto builtin = builtin_grid_name(grid.file);
    Read& read = files[builtin ? grid.file : description(layer)];
    try {
      if (!read.voxels && builtin) {
        read.voxels = std::make_shared<Voxels>(make_builtin_grid(*builtin));
      } else if (!read.voxels) {
        VdbGrids found =
            read_vdb((std::filesystem::path(grid.folder) / grid.file).string(), request_of(layer));
        read = {std::make_shared<Voxels>(std::move(found.voxels)), std::move(found.extent_source),
                std::move(found.warnings)};
      }
    } catch (const std::exception& error) {
      throw std::invalid_argument(fmt::format("{}: key \"grid\": {}", grid.where, error.what()));
    }
    grids[k] =
        std::make_shared<DensityGrid>(layer, read.voxels, cells, read.extent_source, read.warnings);
  }
  return grids;
}

}  // namespace lamella
