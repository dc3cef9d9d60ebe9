#include "volume/voxels/vdb_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "phase/parameters/one_line.h"
#include "phase/parameters/parameters.h"
#include "volume/voxels/vdb_tile.h"

namespace lamella {
namespace {

// Voxels that leaves may hold: their places are numbered with 32 bits.
constexpr std::size_t kMostLeaves = std::size_t{1} << 22;
constexpr std::size_t kMostNames = 20;
enum Wanted { kDensityGrid, kOrientationGrid, kRoughnessGrid, kAlbedoGrid };

std::string text_of(openvdb::Coord c) { return fmt::format("({}, {}, {})", c.x(), c.y(), c.z()); }

template <class Grid>
constexpr int kComponents = std::is_same_v<Grid, openvdb::FloatGrid> ? 1 : 3;

float component(float value, int) { return value; }
float component(const openvdb::Vec3s& value, int k) { return value[k]; }

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "float" of "Tree_float_5_4_3"; other names stay whole.
std::string value_type(const std::string& tree) {
  const std::string text = one_line(tree, 60);
  const std::string head = "Tree_", tail = "_5_4_3";
  return text.starts_with(head) && text.ends_with(tail) && text.size() > head.size() + tail.size()
             ? text.substr(head.size(), text.size() - head.size() - tail.size())
             : text;
}

// What a field may hold. Voxels that are not active may hold 0 where it stands for "not given".
struct Range {
  float low, high;
  bool zero_if_inactive;
  const char* allowed;
};

template <int N>
struct Checked {
  std::string name;
  Range range;

  template <class V>
  typename VoxelField<N>::Value operator()(const V& from, bool active,
                                           const openvdb::Coord& where) const {
    typename VoxelField<N>::Value value;
    for (int k = 0; k < N; ++k) {
      value[k] = component(from, k);
      const bool fits = value[k] >= range.low && value[k] <= range.high;
      if (!fits && !(value[k] == 0 && !active && range.zero_if_inactive))
        throw GridFileError(fmt::format("grid \"{}\": found {} at voxel {}; allowed: {}", name,
                                        value[k], text_of(where), range.allowed));
    }
    return value;
  }
};

// As it is: no voxel of the tile may have it.
template <class Grid, int N>
typename VoxelField<N>::Value background_of(const Grid& grid) {
  typename VoxelField<N>::Value value;
  for (int k = 0; k < N; ++k) value[k] = component(grid.background(), k);
  return value;
}

// The grid as it is, `offset` leading from the density's indices to its own.
template <class Grid, int N>
VoxelField<N> copied(const Grid& grid, const openvdb::Coord& offset, const VdbTile& tile,
                     const Checked<N>& checked) {
  const openvdb::CoordBBox box(tile.box.min() + offset, tile.box.max() + offset);
  const auto& tree = grid.tree();
  VoxelField<N> field(tile.extent(), background_of<Grid, N>(grid));
  auto tiles = tree.cbeginValueAll();
  tiles.setMaxDepth(decltype(tiles)::LEAF_DEPTH - 1);
  for (; tiles; ++tiles) {
    openvdb::CoordBBox where = tiles.getBoundingBox();
    const bool active = tiles.isValueOn();
    if (active) (void)checked(*tiles, true, where.min());
    where.intersect(box);
    if (where.empty()) continue;
    const openvdb::Coord lo = where.min() - box.min(), hi = where.max() - box.min();
    field.fill({lo.x(), lo.y(), lo.z()}, {hi.x() + 1, hi.y() + 1, hi.z() + 1},
               checked(*tiles, active, where.min()));
  }
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const auto* values = leaf->buffer().data();
    const bool inside = box.hasOverlap(leaf->getNodeBoundingBox());
    for (openvdb::Index n = 0; n < openvdb::FloatTree::LeafNodeType::SIZE; ++n) {
      const bool active = leaf->isValueOn(n);
      if (!active && !inside) continue;
      const openvdb::Coord where = leaf->offsetToGlobalCoord(n);
      const bool counts = inside && box.isInside(where);
      if (!active && !counts) continue;
      const auto value = checked(values[n], active, where);
      if (!counts) continue;
      const openvdb::Coord i = where - box.min();
      field.set({i.x(), i.y(), i.z()}, value);
    }
  }
  return field;
}

// Values of the background that no voxel of the tile may have.
template <int N>
void check_background(const VoxelField<N>& field, const Checked<N>& checked,
                      const typename VoxelField<N>::Value& background, const VdbTile& tile) {
  bool fits = true;
  for (const float v : background)
    fits = fits && ((v >= checked.range.low && v <= checked.range.high) ||
                    (v == 0 && checked.range.zero_if_inactive));
  if (fits) return;
  for_each_value(field, [&](VoxelIndex i, const typename VoxelField<N>::Value& value) {
    for (const float v : value)
      if (!(v >= checked.range.low && v <= checked.range.high) &&
          !(v == 0 && checked.range.zero_if_inactive))
        throw GridFileError(fmt::format(
            "grid \"{}\": found {} at voxel {}, the background; allowed: {}", checked.name, v,
            text_of(tile.box.min() + openvdb::Coord(i[0], i[1], i[2])), checked.range.allowed));
  });
}

// A grid of other voxels, sampled at the middles of the density's, where that is not 0.
template <class Grid, int N>
VoxelField<N> sampled(const Grid& grid, const VdbIndexMap& map, const VdbTile& tile,
                      const VoxelField<1>& density, const typename VoxelField<N>::Value& elsewhere,
                      const Checked<N>& checked) {
  for (auto it = grid.tree().cbeginValueOn(); it; ++it)
    (void)checked(*it, true, it.getBoundingBox().min());
  VoxelField<N> field(tile.extent(), elsewhere);
  const auto accessor = grid.getConstAccessor();
  const VoxelIndex n = tile.extent().voxels;
  VoxelIndex b, i;
  for (b[2] = 0; b[2] < n[2]; b[2] += kBlockVoxels)
    for (b[1] = 0; b[1] < n[1]; b[1] += kBlockVoxels)
      for (b[0] = 0; b[0] < n[0]; b[0] += kBlockVoxels) {
        if (density.is_uniform(b) && density.at(b)[0] == 0) continue;
        for (i[2] = b[2]; i[2] < std::min(b[2] + kBlockVoxels, n[2]); ++i[2])
          for (i[1] = b[1]; i[1] < std::min(b[1] + kBlockVoxels, n[1]); ++i[1])
            for (i[0] = b[0]; i[0] < std::min(b[0] + kBlockVoxels, n[0]); ++i[0]) {
              const openvdb::Coord j = map(tile.box.min() + openvdb::Coord(i[0], i[1], i[2]));
              typename Grid::ValueType value;
              const bool active = accessor.probeValue(j, value);
              field.set(i, checked(value, active, j));
            }
      }
  return field;
}

class FieldReader {
 public:
  FieldReader(VdbArchive& archive, const VdbRequest& request)
      : archive_(archive), request_(request) {}

  VdbGrids read() {
    const std::string& name = request_.names[kDensityGrid];
    const auto density = grid<openvdb::FloatGrid>(kDensityGrid);
    if (density->getGridClass() == openvdb::GRID_LEVEL_SET)
      throw GridFileError(
          fmt::format("grid \"{}\": found a level set; allowed: a fog volume", name));
    tile_ = tile_of(*density, name, archive_.metadata(), request_);
    lattice_ = lattice_of(*density, name);
    warnings_.insert(warnings_.end(), tile_.warnings.begin(), tile_.warnings.end());
    constexpr float kMost = std::numeric_limits<float>::max();
    VdbGrids out{Voxels(tile_.extent())};
    out.voxels.density = field<openvdb::FloatGrid, 1>(
        *density, {0, 0, 0}, {name, {0, kMost, false, "a finite number, 0 or more"}});
    if (const auto g = grid<openvdb::Vec3SGrid>(kOrientationGrid))
      out.voxels.orientation =
          placed<openvdb::Vec3SGrid, 3>(*g, kOrientationGrid, out.voxels.density, {0, 0, 0},
                                        {-kMost, kMost, false, "finite numbers"});
    if (const auto g = grid<openvdb::FloatGrid>(kRoughnessGrid))
      out.voxels.roughness = placed<openvdb::FloatGrid, 1>(
          *g, kRoughnessGrid, out.voxels.density, {0},
          {std::numeric_limits<float>::min(), 1, true, "a number in (0, 1]"});
    if (const auto g = grid<openvdb::Vec3SGrid>(kAlbedoGrid))
      out.voxels.albedo = placed<openvdb::Vec3SGrid, 3>(
          *g, kAlbedoGrid, out.voxels.density, {1, 1, 1}, {0, 1, false, "numbers in [0, 1]"});
    const openvdb::Coord first = tile_.box.min();
    out.first_voxel = {first.x(), first.y(), first.z()};
    out.extent_source = tile_.source;
    out.warnings = std::move(warnings_);
    return out;
  }

 private:
  [[nodiscard]] std::string names() const {
    std::string text;
    for (std::size_t k = 0; k < archive_.entries().size(); ++k) {
      if (k == kMostNames) return text + ", ...";
      text += fmt::format("{}\"{}\"", text.empty() ? "" : ", ",
                          one_line(archive_.entries()[k].name, 60));
    }
    return text.empty() ? "no grid" : "the grids " + text;
  }

  // The one grid of that name, or nullptr where it may be missing.
  template <class Grid>
  typename Grid::Ptr grid(Wanted which) {
    const std::string& name = request_.names[which];
    const VdbArchive::Entry *found = nullptr, *alike = nullptr;
    for (const VdbArchive::Entry& entry : archive_.entries()) {
      if (entry.name != name) {
        if (lower(entry.name) == lower(name)) alike = &entry;
        continue;
      }
      if (found)
        throw GridFileError(
            fmt::format("found two grids named \"{}\"; allowed: one", one_line(name)));
      found = &entry;
    }
    const char* const values = kComponents<Grid> == 1 ? "float" : "vec3s (three floats)";
    if (!found) {
      std::vector<std::string> there;
      for (const VdbArchive::Entry& entry : archive_.entries())
        there.push_back(one_line(entry.name, 60));
      std::string hint = alike ? fmt::format("did you mean \"{}\"?", one_line(alike->name, 60))
                               : suggestion(name, there);
      if (request_.required[which])
        throw GridFileError(fmt::format(
            "found {}; allowed: a {} grid named \"{}\"{}{}", names(),
            kComponents<Grid> == 1 ? "float" : "vec3s", one_line(name),
            hint.empty() ? "" : ", " + hint,
            which == kDensityGrid && name == "density" ? ", or the layer's key density_grid" : ""));
      if (alike)
        warnings_.push_back(fmt::format("grid \"{}\" is not read; {}_grid = \"{}\" reads it",
                                        one_line(alike->name, 60), name,
                                        one_line(alike->name, 60)));
      return nullptr;
    }
    if (found->type != Grid::gridType())
      throw GridFileError(fmt::format("grid \"{}\": found values of type {}; allowed: {}",
                                      one_line(name), value_type(found->type), values));
    auto typed = openvdb::gridPtrCast<Grid>(archive_.read(*found));
    if (!typed)
      throw GridFileError(fmt::format("grid \"{}\": found no values of type {}; allowed: {}",
                                      one_line(name), values, values));
    if (typed->tree().leafCount() > kMostLeaves)
      throw GridFileError(
          fmt::format("grid \"{}\": found {} leaves of 8 x 8 x 8 voxels; allowed: at most {}",
                      one_line(name), typed->tree().leafCount(), kMostLeaves));
    return typed;
  }

  template <class Grid, int N>
  VoxelField<N> field(const Grid& grid, const openvdb::Coord& offset, const Checked<N>& checked) {
    VoxelField<N> out = copied<Grid, N>(grid, offset, tile_, checked);
    check_background<N>(out, checked, background_of<Grid, N>(grid), tile_);
    return out;
  }

  // A grid beside the density, on the density's voxels.
  template <class Grid, int N>
  VoxelField<N> placed(const Grid& grid, Wanted which, const VoxelField<1>& density,
                       const typename VoxelField<N>::Value& elsewhere, const Range& range) {
    const std::string& name = request_.names[which];
    const Checked<N> checked{name, range};
    const VdbLattice lattice = lattice_of(grid, name);
    const auto noted = noted_box(grid, {});
    const openvdb::CoordBBox box = noted ? noted->box : grid.evalActiveVoxelBoundingBox();
    const VdbIndexMap map = index_map(lattice_, tile_.box, lattice, box);
    if (const auto offset = map.offset()) return field<Grid, N>(grid, *offset, checked);
    for (int a = 0; a < 3; ++a)
      if (map.scale[a] > 1 + 1e-3) {
        warnings_.push_back(fmt::format(
            "grid \"{}\": its voxels are smaller than the density's; each density voxel takes the "
            "value at its middle",
            name));
        break;
      }
    return sampled<Grid, N>(grid, map, tile_, density, elsewhere, checked);
  }

  VdbArchive& archive_;
  const VdbRequest& request_;
  VdbTile tile_;
  VdbLattice lattice_;
  std::vector<std::string> warnings_;
};

}  // namespace

VdbGrids read_fields(VdbArchive& archive, const VdbRequest& request) {
  return FieldReader(archive, request).read();
}

}  // namespace lamella
