// .vdb files out, and level sets. The files vdb_*.cpp are all that includes OpenVDB. Written
// against what its versions 10 to 12 share: the grid containers, io::File, io::Archive with
// GridDescriptor, and ParticlesToLevelSet; should a version differ, these files are the place.
#include "volume/voxels/vdb_write.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/ParticlesToLevelSet.h>

#include <cmath>

#include "phase/parameters/one_line.h"
#include "volume/voxels/vdb_identity.h"
#include "volume/voxels/vdb_tile.h"

namespace lamella {
namespace {

template <class Grid, int N>
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

void write_vdb_grids(const std::string& path, const Voxels& voxels, Vec3<double> voxel_size) {
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
    file.close();
    set_identity_by_content(path);
  } catch (const std::exception& failure) {
    throw GridFileError(fmt::format("{}: cannot be written ({})", path, one_line(failure.what())));
  }
}

LevelSetMeasure measure_spheres(std::span<const Vec3<double>> centres, double radius, double voxel,
                                Vec3<double> size) {
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
