#include "volume/voxels/majorant_cells.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// Cost of a boundary in tentative collisions: a guess that only speed knows.
constexpr double kStep = 0.4;
// Widens cones by more than the rounding of float.
constexpr double kConeMargin = 1e-6;

Direction middle_of(const AxisCone& cone) { return normalized(Direction{cone.x, cone.y, cone.z}); }

AxisCone cone_around(Direction middle, double widest) {
  widest = std::min(kPi, widest + kConeMargin);
  return {static_cast<float>(middle.x), static_cast<float>(middle.y), static_cast<float>(middle.z),
          static_cast<float>(std::cos(widest)), static_cast<float>(std::sin(widest))};
}

// The smallest cone about the sum of the two cones' middles, which is easy to find.
AxisCone joined(const AxisCone& a, AxisCone b, bool two_sided) {
  if (two_sided && a.x * b.x + a.y * b.y + a.z * b.z < 0) b = {-b.x, -b.y, -b.z, b.cosine, b.sine};
  const Direction sum{double(a.x) + b.x, double(a.y) + b.y, double(a.z) + b.z};
  if (dot(sum, sum) < 1e-6) return {a.x, a.y, a.z, -1, 0};  // all directions
  const Direction middle = normalized(sum);
  double widest = 0;
  for (const AxisCone& cone : {a, b}) {
    const Direction axis = middle_of(cone);
    const double apart = std::atan2(length(cross(middle, axis)), dot(middle, axis));
    widest = std::max(widest, apart + std::atan2(cone.sine, cone.cosine));
  }
  return cone_around(middle, widest);
}

class TableMaker {
 public:
  explicit TableMaker(const MajorantInput& input)
      : in_(input), extent_(input.density.extent()), blocks_(extent_.blocks()) {
    table_.cells.resize(extent_.block_count());
    if (!in_.axis) return;
    table_.cones.resize(table_.cells.size());
    has_cone_.resize(table_.cells.size());
  }

  // Bounds of the blocks themselves. Empty voxels bound nothing.
  void bound_blocks() {
    for_each_in_box({}, blocks_, 1, [&](VoxelIndex b) { bound_block(b); });
  }

  // Merges blocks from below: a cell of level k is taken whole if crossing it then costs no more
  // than crossing its parts; the global cell in any case, and no other.
  void merge(bool global) {
    int top = 0;
    while ((1 << top) < std::max({blocks_[0], blocks_[1], blocks_[2]})) ++top;
    cost_.resize(table_.cells.size());
    for (int level = 0; level <= top; ++level)
      for_each_in_box({}, blocks_, 1 << level, [&](VoxelIndex b) {
        VoxelIndex end;
        for (int a = 0; a < 3; ++a) end[a] = std::min(b[a] + (1 << level), blocks_[a]);
        MajorantCell whole = largest(b, end);
        whole.level = static_cast<std::uint8_t>(level);
        double& cost = cost_[block_at(b)];
        const double own = cost_of(b, end, whole.density);
        if (level == 0) {
          cost = own;
          return;
        }
        double parts = 0;
        for_each_in_box(b, end, 1 << (level - 1),
                        [&](VoxelIndex i) { parts += cost_[block_at(i)]; });
        const bool merges = global ? level == top : own <= parts;
        cost = merges ? own : parts;
        if (merges) write(b, end, whole);
      });
  }

  [[nodiscard]] MajorantTable take() { return std::move(table_); }

 private:
  [[nodiscard]] std::size_t block_at(VoxelIndex b) const {
    return extent_.block_of({b[0] * kBlockVoxels, b[1] * kBlockVoxels, b[2] * kBlockVoxels});
  }
  [[nodiscard]] Direction axis(VoxelIndex i) const {
    const auto& a = in_.axis->at(i);
    return {a[0], a[1], a[2]};
  }

  void bound_block(VoxelIndex b) {
    VoxelIndex lo, hi;
    for (int a = 0; a < 3; ++a) {
      lo[a] = b[a] * kBlockVoxels;
      hi[a] = std::min(lo[a] + kBlockVoxels, extent_.voxels[a]);
    }
    MajorantCell& cell = table_.cells[extent_.block_of(lo)];
    if (in_.density.is_uniform(lo) && !in_.axis && !in_.palette_index) {
      cell.density = in_.density.at(lo)[0];
      return;
    }
    Direction sum{0, 0, 0}, reference{0, 0, 0};
    for_each_in_box(lo, hi, 1, [&](VoxelIndex i) {
      const float density = in_.density.at(i)[0];
      if (!(density > 0)) return;
      cell.density = std::max(cell.density, density);
      if (in_.palette_index)
        cell.roughest =
            std::max(cell.roughest, static_cast<std::uint8_t>(in_.palette_index->at(i)[0]));
      if (!in_.axis) return;
      Direction a = axis(i);
      if (dot(reference, reference) == 0) reference = a;
      if (in_.two_sided && dot(a, reference) < 0) a = -a;
      sum = sum + a;
    });
    if (!in_.axis || !(cell.density > 0)) return;
    AxisCone cone{0, 0, 1, -1, 0};
    if (dot(sum, sum) > 1e-6) {
      const Direction middle = normalized(sum);
      double widest = 0;
      for_each_in_box(lo, hi, 1, [&](VoxelIndex i) {
        if (!(in_.density.at(i)[0] > 0)) return;
        const Direction a = axis(i);
        double c = dot(a, middle);
        if (in_.two_sided) c = std::abs(c);
        widest = std::max(widest, std::atan2(length(cross(a, middle)), c));
      });
      cone = cone_around(middle, widest);
    }
    table_.cones[extent_.block_of(lo)] = cone;
    has_cone_[extent_.block_of(lo)] = true;
  }

  // The bounds of all blocks of the box.
  [[nodiscard]] MajorantCell largest(VoxelIndex b, VoxelIndex end) const {
    MajorantCell whole;
    for_each_in_box(b, end, 1, [&](VoxelIndex i) {
      const MajorantCell& cell = table_.cells[block_at(i)];
      whole.density = std::max(whole.density, cell.density);
      whole.roughest = std::max(whole.roughest, cell.roughest);
    });
    return whole;
  }

  // Of crossing a cell, times its volume: per mm of a way its boundaries (1.5 per edge of a cube)
  // and its tentative collisions.
  [[nodiscard]] double cost_of(VoxelIndex b, VoxelIndex end, double density) const {
    const double edge[3] = {in_.voxel_size.x, in_.voxel_size.y, in_.voxel_size.z};
    double volume = 1, boundaries = 0;
    for (int a = 0; a < 3; ++a) {
      const double l =
          edge[a] * (std::min(end[a] * kBlockVoxels, extent_.voxels[a]) - b[a] * kBlockVoxels);
      volume *= l;
      // A cell as wide as the tile has no sides.
      if (a == 2 || b[a] > 0 || end[a] < blocks_[a]) boundaries += 0.5 / l;
    }
    return volume * (kStep * boundaries + in_.layer_density * density);
  }

  // Makes all blocks of the box one cell.
  void write(VoxelIndex b, VoxelIndex end, const MajorantCell& whole) {
    AxisCone cone;
    bool any = false;
    if (in_.axis)
      for_each_in_box(b, end, 1, [&](VoxelIndex i) {
        const std::size_t k = block_at(i);
        if (!has_cone_[k]) return;
        cone = any ? joined(cone, table_.cones[k], in_.two_sided) : table_.cones[k];
        any = true;
      });
    for_each_in_box(b, end, 1, [&](VoxelIndex i) {
      const std::size_t k = block_at(i);
      table_.cells[k] = whole;
      if (!in_.axis) return;
      table_.cones[k] = cone;
      has_cone_[k] = any;
    });
  }

  const MajorantInput& in_;
  VoxelExtent extent_;
  VoxelIndex blocks_;
  MajorantTable table_;
  std::vector<bool> has_cone_;
  std::vector<double> cost_;  // of the best cut of the cell whose first block it is
};

}  // namespace

MajorantTable majorant_table(const MajorantInput& input, MajorantCells kind) {
  TableMaker maker(input);
  maker.bound_blocks();
  if (kind != MajorantCells::blocks) maker.merge(kind == MajorantCells::global);
  return maker.take();
}

}  // namespace lamella
