#include "volume/voxels/vdb_module.h"

#include <openvdb/version.h>

#include "volume/voxels/vdb_archive.h"
#include "volume/voxels/vdb_fields.h"
#include "volume/voxels/vdb_write.h"

namespace lamella {
namespace {

// The answer of f, or the text of the GridFileError that it threw.
template <class Answer, class F>
std::variant<Answer, VdbRefusal> answered(const F& f) {
  try {
    return f();
  } catch (const GridFileError& error) {
    return VdbRefusal{error.what()};
  }
}

std::variant<VdbGrids, VdbRefusal> read(const std::string& path, const VdbRequest& request) {
  return answered<VdbGrids>([&] {
    // Never destroyed, as little as its grids.
    auto& archive = *new VdbArchive(path);
    return read_fields(archive, request);
  });
}

std::variant<std::monostate, VdbRefusal> write(const std::string& path, const Voxels& voxels,
                                               Vec3<double> voxel_size) {
  return answered<std::monostate>([&] {
    write_vdb_grids(path, voxels, voxel_size);
    return std::monostate{};
  });
}

std::variant<LevelSetMeasure, VdbRefusal> measure(std::span<const Vec3<double>> centres,
                                                  double radius, double voxel, Vec3<double> size) {
  return answered<LevelSetMeasure>([&] { return measure_spheres(centres, radius, voxel, size); });
}

}  // namespace
}  // namespace lamella

extern "C" [[gnu::visibility("default")]] const lamella::VdbModule lamella_vdb_module;
extern "C" const lamella::VdbModule lamella_vdb_module{
    .lamella_version = LAMELLA_VERSION,
    .openvdb_version = OPENVDB_LIBRARY_VERSION_STRING,
    .initialize = lamella::initialize_openvdb,
    .read = lamella::read,
    .write = lamella::write,
    .measure_level_set = lamella::measure};
