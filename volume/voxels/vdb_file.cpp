// The only file that includes OpenVDB. Written against what its versions 10 to 12 share: the grid
// containers, io::File opened without delayed loading (which 12 may leave out), and
// ParticlesToLevelSet; should a version differ, this is the place.
#include "volume/voxels/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/ParticlesToLevelSet.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace lamella {
namespace {

// The box that write_vdb covers, so that empty margins are part of the tile.
constexpr char kExtentKey[] = "lamella_voxels";
// Blocks in the table of a field: 128 MiB of it.
constexpr std::size_t kMostBlocks = std::size_t{1} << 24;
// Voxels that leaves may hold: their places are numbered with 32 bits.
constexpr std::size_t kMostLeaves = std::size_t{1} << 22;

void initialize() {
  static const bool done = [] {
    openvdb::initialize();
    return true;
  }();
  (void)done;
}

std::string text_of(openvdb::Coord c) { return fmt::format("({}, {}, {})", c.x(), c.y(), c.z()); }

float component(float value, int) { return value; }
float component(const openvdb::Vec3s& value, int k) { return value[k]; }

template <class Grid>
constexpr int kComponents = std::is_same_v<Grid, openvdb::FloatGrid> ? 1 : 3;

// The grid of that name, or nullptr; another value type than Grid's is an error.
template <class Grid>
typename Grid::Ptr grid_named(const openvdb::GridPtrVec& grids, const std::string& name) {
  for (const auto& grid : grids) {
    if (grid->getName() != name) continue;
    if (auto typed = openvdb::gridPtrCast<Grid>(grid)) return typed;
    throw GridFileError(fmt::format("grid \"{}\": found values of type {}; allowed: {}", name,
                                    grid->valueType(),
                                    kComponents<Grid> == 1 ? "float" : "vec3s (three floats)"));
  }
  return nullptr;
}

void check_transform(const openvdb::math::Transform& transform) {
  if (transform.isLinear()) {
    const auto m = transform.baseMap()->getAffineMap()->getMat4();
    bool diagonal = true;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        diagonal = diagonal && (i == j ? m(i, i) > 0 : std::abs(m(i, j)) <= 1e-6 * m(i, i));
    if (diagonal) return;
  }
  throw GridFileError(
      "grid \"density\": found a transform that rotates, mirrors, shears or tapers; allowed: scale "
      "and translation, z up");
}

struct Box {
  openvdb::CoordBBox box;

  [[nodiscard]] VoxelExtent extent() const {
    const openvdb::Coord d = box.dim();
    return {{d.x(), d.y(), d.z()}};
  }
};

Box box_of(const openvdb::FloatGrid& density) {
  const openvdb::CoordBBox active = density.evalActiveVoxelBoundingBox();
  if (density.activeVoxelCount() == 0)
    throw GridFileError(
        "grid \"density\": found an empty grid, without an active voxel; allowed: one or more");
  Box out{active};
  if (const auto noted = density.getMetadata<openvdb::Vec3IMetadata>(kExtentKey)) {
    const openvdb::Vec3i n = noted->value();
    if (n.x() > 0 && n.y() > 0 && n.z() > 0)
      out.box = openvdb::CoordBBox({0, 0, 0}, {n.x() - 1, n.y() - 1, n.z() - 1});
    if (!out.box.isInside(active))
      throw GridFileError(fmt::format(
          "grid \"density\": found voxels {} to {}; allowed: those within the file's "
          "{} of {} x {} x {}",
          text_of(active.min()), text_of(active.max()), kExtentKey, n.x(), n.y(), n.z()));
  }
  const auto dim = [&](int a) {
    return static_cast<std::int64_t>(out.box.max()[a]) - out.box.min()[a] + 1;
  };
  double blocks = 1;
  for (int a = 0; a < 3; ++a) blocks *= std::ceil(static_cast<double>(dim(a)) / kBlockVoxels);
  if (blocks > static_cast<double>(kMostBlocks))
    throw GridFileError(
        fmt::format("grid \"density\": found {} x {} x {} voxels; allowed: at most 2^24 blocks of "
                    "8 x 8 x 8",
                    dim(0), dim(1), dim(2)));
  return out;
}

// Copies the active values in the box; each component must lie in [low, high].
template <class Grid, int N = kComponents<Grid>>
void copy_values(const Grid& grid, const std::string& name, const Box& box, float low, float high,
                 const std::string& allowed, VoxelField<N>& field) {
  if (grid.tree().leafCount() > kMostLeaves)
    throw GridFileError(
        fmt::format("grid \"{}\": found {} leaves of 8 x 8 x 8 voxels; allowed: at "
                    "most {}",
                    name, grid.tree().leafCount(), kMostLeaves));
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    openvdb::CoordBBox where = it.getBoundingBox();
    typename VoxelField<N>::Value value;
    for (int k = 0; k < N; ++k) {
      value[k] = component(*it, k);
      if (!(value[k] >= low && value[k] <= high && std::isfinite(value[k])))
        throw GridFileError(fmt::format("grid \"{}\": found {} at voxel {}; allowed: {}", name,
                                        value[k], text_of(where.min()), allowed));
    }
    where.intersect(box.box);
    if (where.empty()) continue;
    const openvdb::Coord lo = where.min() - box.box.min(), hi = where.max() - box.box.min();
    if (it.isVoxelValue())
      field.set({lo.x(), lo.y(), lo.z()}, value);
    else
      field.fill({lo.x(), lo.y(), lo.z()}, {hi.x() + 1, hi.y() + 1, hi.z() + 1}, value);
  }
}

openvdb::GridPtrVec grids_of(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw GridFileError(fmt::format("{}: is a directory; allowed: a .vdb file", path));
  if (!std::ifstream(path))
    throw GridFileError(fmt::format("{}: {}; allowed: a .vdb file", path, std::strerror(errno)));
  try {
    openvdb::io::File file(path);
    file.open(false);
    const openvdb::GridPtrVecPtr grids = file.getGrids();
    return *grids;
  } catch (const std::exception& failure) {
    throw GridFileError(fmt::format("{}: found no readable .vdb file ({}); allowed: a .vdb file",
                                    path, failure.what()));
  }
}

Voxels voxels_of(const openvdb::GridPtrVec& grids) {
  const auto density = grid_named<openvdb::FloatGrid>(grids, "density");
  if (!density) {
    std::string names;
    for (const auto& grid : grids)
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", grid->getName());
    throw GridFileError(fmt::format("found {}; allowed: a float grid named \"density\"",
                                    names.empty() ? "no grid" : "the grids " + names));
  }
  if (density->getGridClass() == openvdb::GRID_LEVEL_SET)
    throw GridFileError("grid \"density\": found a level set; allowed: a fog volume");
  check_transform(density->transform());
  const Box box = box_of(*density);
  Voxels out(box.extent());
  constexpr float kMost = std::numeric_limits<float>::max();
  copy_values(*density, "density", box, 0, kMost, "a finite number, 0 or more", out.density);
  if (const auto grid = grid_named<openvdb::Vec3SGrid>(grids, "orientation")) {
    out.orientation.emplace(out.extent());
    copy_values(*grid, "orientation", box, -kMost, kMost, "finite numbers", *out.orientation);
  }
  if (const auto grid = grid_named<openvdb::FloatGrid>(grids, "roughness")) {
    out.roughness.emplace(out.extent());
    copy_values(*grid, "roughness", box, std::numeric_limits<float>::min(), 1, "a number in (0, 1]",
                *out.roughness);
  }
  if (const auto grid = grid_named<openvdb::Vec3SGrid>(grids, "albedo")) {
    out.albedo.emplace(out.extent());
    out.albedo->fill({0, 0, 0}, out.extent().voxels, {1, 1, 1});
    copy_values(*grid, "albedo", box, 0, 1, "numbers in [0, 1]", *out.albedo);
  }
  return out;
}

template <class Grid, int N = kComponents<Grid>>
typename Grid::Ptr to_grid(const VoxelField<N>& field, const std::string& name,
                           typename VoxelField<N>::Value background, Vec3<double> voxel_size) {
  typename Grid::ValueType value{};
  const auto set_value = [&](const typename VoxelField<N>::Value& v) {
    if constexpr (N == 1)
      value = v[0];
    else
      value = typename Grid::ValueType(v[0], v[1], v[2]);
  };
  set_value(background);
  auto grid = Grid::create(value);
  grid->setName(name);
  if (name == "density") grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  openvdb::math::Mat4d scale = openvdb::math::Mat4d::identity();
  scale.preScale(openvdb::Vec3d(voxel_size.x, voxel_size.y, voxel_size.z));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(scale));
  auto accessor = grid->getAccessor();
  for_each_voxel(field.extent(), [&](VoxelIndex i) {
    const auto& v = field.at(i);
    if (v == background) return;
    set_value(v);
    accessor.setValue({i[0], i[1], i[2]}, value);
  });
  const VoxelIndex n = field.extent().voxels;
  grid->insertMeta(kExtentKey, openvdb::Vec3IMetadata(openvdb::Vec3i(n[0], n[1], n[2])));
  grid->pruneGrid();
  return grid;
}

// What ParticlesToLevelSet asks of a list of particles.
class Spheres {
 public:
  using PosType = openvdb::Vec3R;
  Spheres(std::span<const Vec3<double>> centres, double shift) : centres_(centres), shift_(shift) {}
  [[nodiscard]] std::size_t size() const { return centres_.size(); }
  void getPos(std::size_t n, openvdb::Vec3R& position) const {
    const Vec3<double>& c = centres_[n];
    position = openvdb::Vec3R(c.x + shift_, c.y + shift_, c.z + shift_);
  }

 private:
  std::span<const Vec3<double>> centres_;
  double shift_;
};

}  // namespace

bool has_openvdb() { return true; }

std::string openvdb_version() { return OPENVDB_LIBRARY_VERSION_STRING; }

Voxels read_vdb(const std::string& path) {
  initialize();
  const openvdb::GridPtrVec grids = grids_of(path);
  try {
    return voxels_of(grids);
  } catch (const GridFileError& error) {
    throw GridFileError(fmt::format("{}: {}", path, error.what()));
  }
}

void write_vdb(const std::string& path, const Voxels& voxels, Vec3<double> voxel_size) {
  initialize();
  openvdb::GridCPtrVec grids;
  grids.push_back(to_grid<openvdb::FloatGrid>(voxels.density, "density", {0}, voxel_size));
  if (voxels.orientation)
    grids.push_back(
        to_grid<openvdb::Vec3SGrid>(*voxels.orientation, "orientation", {0, 0, 0}, voxel_size));
  if (voxels.roughness)
    grids.push_back(to_grid<openvdb::FloatGrid>(*voxels.roughness, "roughness", {0}, voxel_size));
  if (voxels.albedo)
    grids.push_back(to_grid<openvdb::Vec3SGrid>(*voxels.albedo, "albedo", {1, 1, 1}, voxel_size));
  try {
    openvdb::io::File file(path);
    file.write(grids);
  } catch (const std::exception& failure) {
    throw GridFileError(fmt::format("{}: cannot be written ({})", path, failure.what()));
  }
}

LevelSetMeasure measure_level_set(std::span<const Vec3<double>> centres, double radius,
                                  double voxel, Vec3<double> size) {
  initialize();
  const auto grid = openvdb::createLevelSet<openvdb::FloatGrid>(voxel, 3.0);
  openvdb::tools::ParticlesToLevelSet<openvdb::FloatGrid> raster(*grid);
  raster.setRmax(1e9);
  // Index i stands for the middle of voxel i.
  raster.rasterizeSpheres(Spheres(centres, -0.5 * voxel), radius);
  raster.finalize();
  if (raster.ignoredParticles())
    throw GridFileError(
        fmt::format("found a radius of {} voxels; allowed: 1.5 or more", radius / voxel));
  const int n[3] = {static_cast<int>(std::lround(size.x / voxel)),
                    static_cast<int>(std::lround(size.y / voxel)),
                    static_cast<int>(std::lround(size.z / voxel))};
  const auto accessor = grid->getConstAccessor();
  // Both kernels are symmetric in the distance, so that what a curved surface gains on one side of
  // it, it loses on the other.
  const double width = 1.5 * voxel;
  double inside = 0, area = 0;
  openvdb::Coord i;
  for (i[2] = 0; i[2] < n[2]; ++i[2])
    for (i[1] = 0; i[1] < n[1]; ++i[1])
      for (i[0] = 0; i[0] < n[0]; ++i[0]) {
        const double t = accessor.getValue(i) / width;
        constexpr double pi = 3.14159265358979323846;
        if (t <= -1) {
          inside += 1;
        } else if (t < 1) {
          inside += 0.5 * (1 - t - std::sin(pi * t) / pi);
          area += 0.5 * (1 + std::cos(pi * t)) / width;
        }
      }
  const double count = static_cast<double>(n[0]) * n[1] * n[2];
  return {inside / count, area / count};
}

}  // namespace lamella
