#include "volume/voxels/ray_table.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "phase/medium/medium.h"

namespace lamella {
namespace {

constexpr std::uint32_t kInside = kBlockVoxels * kBlockVoxels * kBlockVoxels;

bool lanes_take(const DensityGrid& grid) {
  const VoxelIndex n = grid.extent().voxels;
  if (std::max({n[0], n[1], n[2]}) > GridRayTable::kMostVoxelsAcross) return false;
  if (!grid.is_local()) return true;
  const MediumTraits of = traits(grid.palette()[0]);
  return of.two_sided && of.has_axis && grid.has_orientation();
}

// The numbers of a voxel.
class Records {
 public:
  explicit Records(const DensityGrid& grid) : grid_(grid) {
    if (!grid.is_local()) return;
    for (const Medium& medium : grid.palette()) {
      const double across = sigma(medium, {1, 0, 0}), along = sigma(medium, {0, 0, 1});
      across2_.push_back(across * across);
      difference_.push_back(along * along - across * across);
      largest_ = std::max({largest_, across, along});
      if (difference_.back() != 0) sign_ = difference_.back() > 0 ? 1 : -1;
    }
  }
  [[nodiscard]] float sign() const { return sign_; }
  [[nodiscard]] double largest() const { return largest_; }

  void append(VoxelIndex i, std::vector<float>& to) const {
    const double rho = grid_.density(i);
    if (across2_.empty()) {
      to.push_back(static_cast<float>(rho));
      return;
    }
    const int k = grid_.palette_index(i);
    const double factor = rho * std::sqrt(std::abs(difference_[k]));
    const Direction axis = grid_.axis(i);
    for (const double x :
         {rho * rho * across2_[k], factor * axis.x, factor * axis.y, factor * axis.z})
      to.push_back(static_cast<float>(x));
  }

 private:
  const DensityGrid& grid_;
  std::vector<double> across2_, difference_;  // of the palette's media
  double largest_ = 0;
  float sign_ = 0;
};

}  // namespace

std::shared_ptr<const GridRayTable> make_ray_table(const DensityGrid& grid) {
  if (!lanes_take(grid)) return nullptr;
  const Records records(grid);
  auto table = std::make_shared<GridRayTable>();
  const VoxelExtent& extent = grid.extent();
  table->voxels = extent.voxels;
  table->blocks = extent.blocks();
  table->turned = grid.is_local();
  table->sign = records.sign();
  table->largest_sigma = records.largest();
  const std::size_t numbers = table->turned ? 4 : 1;
  table->block_entries.reserve(4 * extent.block_count());
  bool fits = true;
  for_each_in_box({}, table->blocks, 1, [&](VoxelIndex b) {
    const VoxelIndex lo{b[0] * kBlockVoxels, b[1] * kBlockVoxels, b[2] * kBlockVoxels};
    const MajorantCell& cell = grid.cell(lo);
    const bool uniform = grid.voxels().density.is_uniform(lo) && !table->turned;
    const std::size_t first = table->records.size() / numbers;
    const auto bits = [&](std::uint32_t x) {
      table->block_entries.push_back(std::bit_cast<float>(x));
    };
    table->block_entries.push_back(cell.density);
    bits((static_cast<std::uint32_t>(kBlockVoxels) << cell.level) - 1);
    bits(static_cast<std::uint32_t>(first));
    bits(uniform ? 0 : kInside - 1);
    fits = fits && first + kInside <= GridRayTable::kMostRecords;
    if (!fits) return;
    if (uniform) {
      records.append(lo, table->records);
      return;
    }
    for_each_in_box({}, {kBlockVoxels, kBlockVoxels, kBlockVoxels}, 1, [&](VoxelIndex v) {
      const VoxelIndex i{lo[0] + v[0], lo[1] + v[1], lo[2] + v[2]};
      const bool inside =
          i[0] < extent.voxels[0] && i[1] < extent.voxels[1] && i[2] < extent.voxels[2];
      if (inside)
        records.append(i, table->records);
      else
        table->records.insert(table->records.end(), numbers, 0.0f);
    });
  });
  return fits ? table : nullptr;
}

}  // namespace lamella
