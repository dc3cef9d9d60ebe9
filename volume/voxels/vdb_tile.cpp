#include "volume/voxels/vdb_tile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// Of a voxel: places that differ by less are the same.
constexpr double kSame = 1e-3;

std::string text_of(const openvdb::Coord& c) {
  return fmt::format("({}, {}, {})", c.x(), c.y(), c.z());
}

std::string text_of(const std::array<double, 3>& v) {
  return fmt::format("{:.6g} x {:.6g} x {:.6g}", v[0], v[1], v[2]);
}

openvdb::CoordBBox box_from(const VoxelIndex& first, const VoxelIndex& n) {
  return {openvdb::Coord(first[0], first[1], first[2]),
          openvdb::Coord(first[0] + n[0] - 1, first[1] + n[1] - 1, first[2] + n[2] - 1)};
}

void check_count(const openvdb::CoordBBox& box, const std::string& name) {
  const auto dim = [&](int a) {
    return static_cast<std::int64_t>(box.max()[a]) - box.min()[a] + 1;
  };
  double blocks = 1;
  for (int a = 0; a < 3; ++a) blocks *= std::ceil(static_cast<double>(dim(a)) / kBlockVoxels);
  if (blocks > static_cast<double>(kMostBlocks))
    throw GridFileError(
        fmt::format("grid \"{}\": found {} x {} x {} voxels; allowed: at most 2^24 blocks of "
                    "8 x 8 x 8",
                    name, dim(0), dim(1), dim(2)));
}

void check_inside(const openvdb::CoordBBox& active, const openvdb::CoordBBox& box,
                  const std::string& name, const std::string& source) {
  if (active.empty() || box.isInside(active)) return;
  throw GridFileError(
      fmt::format("grid \"{}\": found voxels {} to {}; allowed: those within {} to {}, by {}", name,
                  text_of(active.min()), text_of(active.max()), text_of(box.min()),
                  text_of(box.max()), source));
}

// Counts that the layer's size gives over the file's voxel size, if all three are whole numbers.
std::optional<VoxelIndex> counts_by_size(const std::array<double, 3>& scale,
                                         const std::array<double, 3>& size) {
  VoxelIndex n{};
  for (int a = 0; a < 3; ++a) {
    const double count = size[a] / scale[a], whole = std::round(count);
    if (!(whole >= 1 && whole <= 1 << 20 && std::abs(count - whole) <= kSame)) return std::nullopt;
    n[a] = static_cast<int>(whole);
  }
  return n;
}

// Whether the file's voxels make a tile of another size than the layer's. The transform that every
// grid begins with, voxels of edge 1, says nothing of lengths, but still of proportions.
bool contradicts(const std::array<double, 3>& scale, const VoxelIndex& n,
                 const std::array<double, 3>& size) {
  const bool plain = scale == std::array<double, 3>{1, 1, 1};
  const double unit = plain ? size[0] / n[0] : 1;
  for (int a = 0; a < 3; ++a)
    if (std::abs(scale[a] * unit * n[a] / size[a] - 1) > kSame) return true;
  return false;
}

}  // namespace

std::optional<NotedBox> noted_box(const openvdb::GridBase& grid, const openvdb::MetaMap& file) {
  // file_base_resolution: Mantaflow, and so the caches of Blender from 2.82 on, per grid;
  // blender/smoke/resolution: those of earlier versions, per file.
  const auto counts = [](const openvdb::MetaMap& map, const char* key) {
    return map.getMetadata<openvdb::Vec3IMetadata>(key);
  };
  for (const char* key : {kExtentKey, "file_base_resolution", "blender/smoke/resolution"}) {
    auto noted = counts(grid, key);
    if (!noted) noted = counts(file, key);
    if (!noted) continue;
    const openvdb::Vec3i n = noted->value();
    if (n.x() > 0 && n.y() > 0 && n.z() > 0)
      return NotedBox{box_from({0, 0, 0}, {n.x(), n.y(), n.z()}), key};
  }
  return std::nullopt;
}

VdbTile tile_of(const openvdb::FloatGrid& density, const std::string& name,
                const openvdb::MetaMap& file, const VdbRequest& request) {
  const openvdb::CoordBBox active = density.evalActiveVoxelBoundingBox();
  const VdbLattice lattice = lattice_of(density, name);
  const auto noted = noted_box(density, file);
  VdbTile tile;
  const auto taken_from = [&](const openvdb::CoordBBox& box, const std::string& source) {
    check_count(box, name);
    check_inside(active, box, name, source);
    tile.box = box;
    tile.source = source;
  };
  std::array<double, 3> size{};
  if (request.size) size = {request.size->x, request.size->y, request.size->z};
  if (request.voxels) {
    taken_from(box_from(request.first_voxel, *request.voxels), "the layer's key \"voxels\"");
  } else if (noted) {
    taken_from(noted->box, fmt::format("the file's {}", noted->key));
  } else {
    if (active.empty())
      throw GridFileError(
          fmt::format("grid \"{}\": found an empty grid, without an active voxel; allowed: one or "
                      "more, or the layer's key voxels = [x, y, z]",
                      name));
    taken_from(active, "the active voxels");
    const auto n = request.size ? counts_by_size(lattice.scale, size) : std::nullopt;
    const openvdb::CoordBBox whole = n ? box_from({0, 0, 0}, *n) : openvdb::CoordBBox();
    if (n && whole != active && whole.isInside(active)) {
      taken_from(whole, "size and thickness over the file's voxel size");
      tile.warnings.push_back(fmt::format(
          "grid \"{}\": its active voxels are {} to {}, size and thickness are {} of the file's "
          "voxels, which are taken as the tile; voxels = [{}, {}, {}] says so, voxels = [{}, {}, "
          "{}] with first_voxel = [{}, {}, {}] crops",
          name, text_of(active.min()), text_of(active.max()),
          fmt::format("{} x {} x {}", (*n)[0], (*n)[1], (*n)[2]), (*n)[0], (*n)[1], (*n)[2],
          active.dim().x(), active.dim().y(), active.dim().z(), active.min().x(), active.min().y(),
          active.min().z()));
    }
  }
  if (request.size && contradicts(lattice.scale, tile.extent().voxels, size)) {
    const VoxelIndex n = tile.extent().voxels;
    std::array<double, 3> edges{};
    for (int a = 0; a < 3; ++a) edges[a] = lattice.scale[a] * n[a];
    tile.warnings.push_back(fmt::format(
        "grid \"{}\": {} x {} x {} voxels ({}) of the file's voxel size {} measure {}, size and "
        "thickness say {}; {}",
        name, n[0], n[1], n[2], tile.source, text_of(lattice.scale), text_of(edges), text_of(size),
        request.voxels || noted
            ? "the layer's lengths are taken"
            : "if margins of zeros are missing, voxels = [x, y, z] gives the tile with them"));
  }
  return tile;
}

VdbLattice lattice_of(const openvdb::GridBase& grid, const std::string& name) {
  const openvdb::math::Transform& transform = grid.transform();
  if (transform.isLinear()) {
    const auto m = transform.baseMap()->getAffineMap()->getMat4();
    bool diagonal = true;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        diagonal = diagonal && (i == j ? m(i, i) > 0 && std::isfinite(m(i, i))
                                       : std::abs(m(i, j)) <= 1e-6 * m(i, i));
    for (int j = 0; j < 3; ++j) diagonal = diagonal && std::isfinite(m(3, j));
    if (diagonal) return {{m(0, 0), m(1, 1), m(2, 2)}, {m(3, 0), m(3, 1), m(3, 2)}};
  }
  throw GridFileError(
      fmt::format("grid \"{}\": found a transform that rotates, mirrors, shears or tapers; "
                  "allowed: scale and translation, z up",
                  name));
}

openvdb::Coord VdbIndexMap::operator()(const openvdb::Coord& i) const {
  openvdb::Coord j;
  for (int a = 0; a < 3; ++a) {
    // A middle that lies on a face, but for rounding, belongs to the upper voxel.
    const double at = std::floor(scale[a] * i[a] + shift[a] + 1e-6);
    j[a] = static_cast<int>(std::clamp(at, -2147483648.0, 2147483647.0));
  }
  return j;
}

std::optional<openvdb::Coord> VdbIndexMap::offset() const {
  for (int a = 0; a < 3; ++a)
    if (std::abs(scale[a] - 1) > 1e-7 || std::abs(shift[a]) > 1e6) return std::nullopt;
  return (*this)(openvdb::Coord(0, 0, 0));
}

VdbIndexMap index_map(const VdbLattice& density, const openvdb::CoordBBox& tile,
                      const VdbLattice& other, const openvdb::CoordBBox& box) {
  // Index i covers [i + c, i + 1 + c): c = 0 for corners, -1/2 for middles.
  const auto boxes_coincide = [&](double c) {
    for (int a = 0; a < 3; ++a) {
      const double slack = kSame * std::min(density.scale[a], other.scale[a]);
      const auto face = [&](const VdbLattice& l, double i) { return l.origin[a] + l.scale[a] * i; };
      if (std::abs(face(density, tile.min()[a] + c) - face(other, box.min()[a] + c)) > slack ||
          std::abs(face(density, tile.max()[a] + 1 + c) - face(other, box.max()[a] + 1 + c)) >
              slack)
        return false;
    }
    return true;
  };
  const auto faces_coincide = [&](double c) {
    for (int a = 0; a < 3; ++a) {
      const bool finer = density.scale[a] < other.scale[a];
      const VdbLattice& fine = finer ? density : other;
      const VdbLattice& coarse = finer ? other : density;
      const double apart =
          (coarse.origin[a] + c * coarse.scale[a] - fine.origin[a]) / fine.scale[a] - c;
      const double ratio = coarse.scale[a] / fine.scale[a];
      if (std::abs(apart - std::round(apart)) > kSame ||
          std::abs(ratio - std::round(ratio)) > kSame)
        return false;
    }
    return true;
  };
  double c = -0.5;
  if (!box.empty() && boxes_coincide(0) != boxes_coincide(-0.5))
    c = boxes_coincide(0) ? 0 : -0.5;
  else if (faces_coincide(0) && !faces_coincide(-0.5))
    c = 0;
  VdbIndexMap map;
  for (int a = 0; a < 3; ++a) {
    map.scale[a] = density.scale[a] / other.scale[a];
    map.shift[a] =
        (density.origin[a] - other.origin[a] + density.scale[a] * (c + 0.5)) / other.scale[a] - c;
  }
  return map;
}

}  // namespace lamella
