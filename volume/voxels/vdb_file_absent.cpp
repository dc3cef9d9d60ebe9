// Stands for the files vdb_*.cpp in a build without OpenVDB.
#include "volume/voxels/vdb_file.h"

namespace lamella {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw GridFileError(what +
                      ": this program was built without OpenVDB (LAMELLA_OPENVDB=OFF); allowed: "
                      "the grids that are built in (builtin:weave, ...)");
}

}  // namespace

bool has_openvdb() { return false; }

std::string openvdb_version() { return {}; }

VdbGrids read_vdb(const std::string& path, const VdbRequest&) { refuse(path); }

void write_vdb(const std::string& path, const Voxels&, Vec3<double>) { refuse(path); }

LevelSetMeasure measure_level_set(std::span<const Vec3<double>>, double, double, Vec3<double>) {
  refuse("the level set of spheres");
}

}  // namespace lamella
