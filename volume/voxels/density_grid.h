#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/voxels/majorant_cells.h"
#include "volume/voxels/voxels.h"

namespace lamella {

/// A layer's density grid, ready for walks: voxels, the media in them, and upper bounds of the
/// extinction. Position in voxels: x, y in [0, n), periodic; z in [0, n), upwards. The extinction
/// of light from w in voxel i is layer density * density(i) * sigma_i(w) [1/mm].
class DensityGrid {
 public:
  /// The layer must have a grid reference. Throws std::invalid_argument, file and key named, if the
  /// medium cannot take what the voxels vary (an orientation without an axis, ...).
  DensityGrid(const Layer& layer, std::shared_ptr<const Voxels> voxels,
              MajorantCells cells = MajorantCells::adaptive, std::string extent_source = {},
              std::vector<std::string> warnings = {});

  [[nodiscard]] const Voxels& voxels() const { return *voxels_; }
  [[nodiscard]] const std::shared_ptr<const Voxels>& shared_voxels() const { return voxels_; }
  /// The origin of the extent ("the active voxels"), and warnings about the file, one line each;
  /// empty for grids that are no file's.
  [[nodiscard]] const std::string& extent_source() const { return extent_source_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }
  [[nodiscard]] const VoxelExtent& extent() const { return extent_; }
  /// Edges of a voxel [mm].
  [[nodiscard]] Direction voxel_size() const { return voxel_size_; }
  [[nodiscard]] double layer_density() const { return layer_density_; }

  /// The media of the voxels, all of the same kind: one, or one per roughness, in rising order.
  /// With an orientation grid, their axis is z and the voxel's frame turns them.
  [[nodiscard]] const std::vector<Medium>& palette() const { return palette_; }
  [[nodiscard]] bool has_orientation() const { return axis_.has_value(); }
  [[nodiscard]] bool has_roughness() const { return index_.has_value(); }
  /// Whether sigma depends on the voxel.
  [[nodiscard]] bool is_local() const { return has_orientation() || has_roughness(); }
  /// Largest difference of a voxel's roughness from the palette's.
  [[nodiscard]] double roughness_error() const { return roughness_error_; }
  /// Whether the albedo grid (none, or left out: white) differs between the channels, or at all.
  [[nodiscard]] bool has_albedo() const { return albedo_; }
  [[nodiscard]] bool is_grey() const { return grey_; }

  [[nodiscard]] double density(VoxelIndex i) const { return voxels_->density.at(i)[0]; }
  [[nodiscard]] int palette_index(VoxelIndex i) const {
    return index_ ? static_cast<int>(index_->at(i)[0]) : 0;
  }
  /// Unit up to the rounding of float; only with an orientation grid.
  [[nodiscard]] Direction axis(VoxelIndex i) const {
    const auto& a = axis_->at(i);
    return {a[0], a[1], a[2]};
  }
  [[nodiscard]] std::array<float, 3> albedo(VoxelIndex i) const { return voxels_->albedo->at(i); }

  [[nodiscard]] const MajorantCell& cell(VoxelIndex i) const { return cells_[extent_.block_of(i)]; }

  /// sigma_i(w). M: the kind of the palette's media.
  template <class M>
  [[nodiscard]] double sigma(VoxelIndex i, Direction w) const {
    const M& medium = *std::get_if<M>(&palette_[palette_index(i)]);
    return axis_ ? sigma_of_cosine(medium, dot(axis(i), w)) : medium.sigma(w);
  }

  /// An upper bound of sigma_j(w) over the voxels j of the cell that voxel i lies in; exact where
  /// the medium does not vary. Fibers along one yarn bound each other closely, crossing ones do
  /// not.
  template <class M>
  [[nodiscard]] double sigma_bound(VoxelIndex i, const MajorantCell& cell, Direction w) const {
    if (bound_everywhere_ > 0) return bound_everywhere_;
    const M& medium = *std::get_if<M>(&palette_[cell.roughest]);
    if (!axis_) return medium.sigma(w);
    const AxisCone& cone = cones_[extent_.block_of(i)];
    const double c = cone.x * w.x + cone.y * w.y + cone.z * w.z;
    return sigma_of_cosine(medium, extreme_cosine(c, cone)) * (1 + 1e-6);
  }

  /// Statistics of the cells, for `lamella explain` and the bench.
  struct CellCount {
    std::size_t blocks = 0, cells = 0, empty_blocks = 0;
  };
  [[nodiscard]] CellCount count_cells() const;

 private:
  void make_palette(const Layer& layer);
  void make_axes(const Layer& layer);

  // sigma of a medium whose axis makes this cosine with w.
  template <class M>
  [[nodiscard]] static double sigma_of_cosine(const M& medium, double c) {
    c = std::clamp(c, -1.0, 1.0);
    return medium.sigma({std::sqrt((1 - c) * (1 + c)), 0, c});
  }

  // The cosine between w and an axis of the cone at which sigma is largest; c: with its middle.
  [[nodiscard]] double extreme_cosine(double c, const AxisCone& cone) const {
    if (two_sided_) c = std::fabs(c);
    c = std::clamp(c, -1.0, 1.0);
    const double s = std::sqrt((1 - c) * (1 + c));
    if (largest_along_axis_)  // the axis nearest to w
      return c >= cone.cosine ? 1 : c * cone.cosine + s * cone.sine;
    // The axis farthest from w, at most at right angles; wider cones hold one.
    if (cone.cosine <= 0) return 0;
    return std::max(0.0, c * cone.cosine - s * cone.sine);
  }

  std::shared_ptr<const Voxels> voxels_;
  std::string extent_source_;
  std::vector<std::string> warnings_;
  VoxelExtent extent_;
  Direction voxel_size_;
  double layer_density_;
  std::vector<Medium> palette_;
  std::optional<VoxelField<3>> axis_;
  std::optional<VoxelField<1>> index_;  // of the palette
  double roughness_error_ = 0;
  bool albedo_ = false, grey_ = true;
  bool two_sided_ = true, largest_along_axis_ = true;
  double bound_everywhere_ = 0;  // a bound of sigma for every direction, if it is the best there is
  std::vector<MajorantCell> cells_;  // per block
  std::vector<AxisCone> cones_;
};

/// The grids of a stack, one per layer, nullptr where there is none: read from their files or
/// generated. Throws std::invalid_argument, file, line and key named.
[[nodiscard]] std::vector<std::shared_ptr<const DensityGrid>> load_grids(
    const Stack& stack, MajorantCells cells = MajorantCells::adaptive);

}  // namespace lamella
