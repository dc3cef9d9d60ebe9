#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

namespace lamella {

/// Edge of the blocks in which voxels are stored and bounded, in voxels: that of OpenVDB's leaf.
inline constexpr int kBlockVoxels = 8;
/// Blocks in the table of a field: 128 MiB of table.
inline constexpr std::size_t kMostBlocks = std::size_t{1} << 24;

using VoxelIndex = std::array<int, 3>;

/// How many voxels a grid has along x, y, z, and the order of its blocks.
struct VoxelExtent {
  VoxelIndex voxels{};

  [[nodiscard]] VoxelIndex blocks() const {
    return {(voxels[0] + kBlockVoxels - 1) / kBlockVoxels,
            (voxels[1] + kBlockVoxels - 1) / kBlockVoxels,
            (voxels[2] + kBlockVoxels - 1) / kBlockVoxels};
  }
  [[nodiscard]] std::size_t block_count() const {
    const VoxelIndex b = blocks();
    return static_cast<std::size_t>(b[0]) * b[1] * b[2];
  }
  [[nodiscard]] std::size_t block_of(VoxelIndex i) const {
    const VoxelIndex b = blocks();
    return (static_cast<std::size_t>(i[2] / kBlockVoxels) * b[1] + i[1] / kBlockVoxels) * b[0] +
           i[0] / kBlockVoxels;
  }
  friend bool operator==(const VoxelExtent&, const VoxelExtent&) = default;
};

/// N numbers per voxel, constant within it, by blocks; a block that holds one value stores it once,
/// so that empty space and coarse tiles cost an entry of the table. z index 0 is the lowest slice.
template <int N>
class VoxelField {
 public:
  using Value = std::array<float, N>;

  /// The same value everywhere.
  explicit VoxelField(VoxelExtent extent, const Value& everywhere = {})
      : extent_(extent),
        width_(extent.blocks()),
        blocks_(extent.block_count()),
        values_(1, everywhere) {}

  [[nodiscard]] const VoxelExtent& extent() const { return extent_; }
  [[nodiscard]] const Value& at(VoxelIndex i) const {
    const Block& block = blocks_[index_of(i)];
    return values_[block.offset + (local(i) & block.mask)];
  }
  /// Whether the block of the voxel holds one value only.
  [[nodiscard]] bool is_uniform(VoxelIndex i) const { return blocks_[index_of(i)].mask == 0; }

  /// The values of the voxel's block: one if it is uniform, else 8^3, x fastest; those beyond the
  /// extent have no meaning.
  [[nodiscard]] std::span<const Value> block(VoxelIndex i) const {
    const Block& block = blocks_[index_of(i)];
    return {values_.data() + block.offset, std::size_t{block.mask} + 1};
  }
  /// Sets the voxel's block as block() gives it: 1 or 8^3 values.
  void set_block(VoxelIndex i, std::span<const Value> values) {
    Block& block = blocks_[index_of(i)];
    const auto mask = static_cast<std::uint32_t>(values.size() - 1);
    if (block.offset == 0 || block.mask != mask) {
      if (mask == 0 && values_[0] == values[0]) {
        block = {};
        return;
      }
      block = {next_offset(), mask};
      values_.resize(values_.size() + values.size());
    }
    std::copy(values.begin(), values.end(), values_.begin() + block.offset);
  }

  void set(VoxelIndex i, const Value& value) {
    Block& block = blocks_[index_of(i)];
    if (block.mask == 0) {
      const Value before = values_[block.offset];
      if (before == value) return;
      block = {next_offset(), kInside};
      values_.resize(values_.size() + kInside + 1, before);
    }
    values_[block.offset + local(i)] = value;
  }

  /// Sets the voxels of the box [from, to), which must lie in the extent.
  void fill(VoxelIndex from, VoxelIndex to, const Value& value) {
    VoxelIndex i;
    for (int bz = from[2] / kBlockVoxels; bz * kBlockVoxels < to[2]; ++bz)
      for (int by = from[1] / kBlockVoxels; by * kBlockVoxels < to[1]; ++by)
        for (int bx = from[0] / kBlockVoxels; bx * kBlockVoxels < to[0]; ++bx) {
          const VoxelIndex b{bx, by, bz};
          VoxelIndex lo, hi;
          bool whole = true;
          for (int a = 0; a < 3; ++a) {
            const int begin = b[a] * kBlockVoxels;
            lo[a] = std::max(begin, from[a]);
            hi[a] = std::min(begin + kBlockVoxels, to[a]);
            whole = whole && lo[a] == begin &&
                    hi[a] == std::min(begin + kBlockVoxels, extent_.voxels[a]);
          }
          Block& block = blocks_[index_of(lo)];
          if (whole && block.mask == 0) {
            if (values_[block.offset] == value) continue;
            block = {next_offset(), 0};
            values_.push_back(value);
            continue;
          }
          for (i[2] = lo[2]; i[2] < hi[2]; ++i[2])
            for (i[1] = lo[1]; i[1] < hi[1]; ++i[1])
              for (i[0] = lo[0]; i[0] < hi[0]; ++i[0]) set(i, value);
        }
  }

 private:
  static constexpr std::uint32_t kInside = kBlockVoxels * kBlockVoxels * kBlockVoxels - 1;
  struct Block {
    std::uint32_t offset = 0, mask = 0;
  };
  // Where the values of one more block begin. Throws std::length_error.
  [[nodiscard]] std::uint32_t next_offset() const {
    if (values_.size() + kInside >= std::numeric_limits<std::uint32_t>::max())
      throw std::length_error(
          "found more than 2^32 voxels with values of their own; allowed: fewer");
    return static_cast<std::uint32_t>(values_.size());
  }
  [[nodiscard]] static std::uint32_t local(VoxelIndex i) {
    constexpr int m = kBlockVoxels - 1;
    return static_cast<std::uint32_t>(((i[2] & m) * kBlockVoxels + (i[1] & m)) * kBlockVoxels +
                                      (i[0] & m));
  }
  [[nodiscard]] std::size_t index_of(VoxelIndex i) const {
    return (static_cast<std::size_t>(i[2] / kBlockVoxels) * width_[1] + i[1] / kBlockVoxels) *
               width_[0] +
           i[0] / kBlockVoxels;
  }

  VoxelExtent extent_;
  VoxelIndex width_;  // in blocks
  std::vector<Block> blocks_;
  std::vector<Value> values_;
};

/// The fields of a grid file or a generator, all on the same voxels.
struct Voxels {
  explicit Voxels(VoxelExtent extent) : density(extent) {}

  VoxelField<1> density;                       ///< >= 0, multiplies the layer's density
  std::optional<VoxelField<3>> orientation{};  ///< axis of the flakes, any length; 0: the layer's
  std::optional<VoxelField<1>> roughness{};    ///< instead of the layer's; 0: the layer's
  std::optional<VoxelField<3>> albedo{};       ///< in [0, 1], multiplies the layer's

  [[nodiscard]] const VoxelExtent& extent() const { return density.extent(); }
};

/// Calls f(index) for every index of the box [from, to) that lies a multiple of `step` from its
/// first corner, x fastest.
template <class F>
void for_each_in_box(VoxelIndex from, VoxelIndex to, int step, const F& f) {
  VoxelIndex i;
  for (i[2] = from[2]; i[2] < to[2]; i[2] += step)
    for (i[1] = from[1]; i[1] < to[1]; i[1] += step)
      for (i[0] = from[0]; i[0] < to[0]; i[0] += step) f(i);
}

/// Calls f(index) for every voxel, x fastest.
template <class F>
void for_each_voxel(const VoxelExtent& extent, const F& f) {
  for_each_in_box({}, extent.voxels, 1, f);
}

/// Calls f(index, value) for every voxel, but for a uniform block once, with its first voxel.
template <int N, class F>
void for_each_value(const VoxelField<N>& field, const F& f) {
  const VoxelIndex n = field.extent().voxels;
  VoxelIndex b, i;
  for (b[2] = 0; b[2] < n[2]; b[2] += kBlockVoxels)
    for (b[1] = 0; b[1] < n[1]; b[1] += kBlockVoxels)
      for (b[0] = 0; b[0] < n[0]; b[0] += kBlockVoxels) {
        if (field.is_uniform(b)) {
          f(b, field.at(b));
          continue;
        }
        for (i[2] = b[2]; i[2] < std::min(b[2] + kBlockVoxels, n[2]); ++i[2])
          for (i[1] = b[1]; i[1] < std::min(b[1] + kBlockVoxels, n[1]); ++i[1])
            for (i[0] = b[0]; i[0] < std::min(b[0] + kBlockVoxels, n[0]); ++i[0]) f(i, field.at(i));
      }
}

}  // namespace lamella
