// The module of OpenVDB from outside: it is loaded at the first call that needs it.
#include "volume/voxels/vdb_file.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include "phase/parameters/one_line.h"
#include "volume/voxels/vdb_module.h"
#include "volume/voxels/vdb_read.h"

namespace lamella {
namespace {

// The module, or why there is none. Found by name through the run path of the program, package or
// library that this file is linked into.
std::variant<const VdbModule*, VdbRefusal> load_module() {
  void* object = dlopen(kVdbModuleFile, RTLD_LAZY | RTLD_LOCAL);
  const auto* module =
      object ? static_cast<const VdbModule*>(dlsym(object, kVdbModuleSymbol)) : nullptr;
  if (!module) {
    const char* const error = dlerror();
    return VdbRefusal{
        fmt::format("the module for .vdb files cannot be loaded ({}); allowed: {} beside the "
                    "program or where Lamella installs it, with OpenVDB's library",
                    one_line(error ? error : "no reason given", 400), kVdbModuleFile)};
  }
  if (std::string_view(module->lamella_version) != LAMELLA_VERSION)
    return VdbRefusal{fmt::format("{}: found the module of Lamella {}; allowed: that of {}",
                                  kVdbModuleFile, one_line(module->lamella_version),
                                  LAMELLA_VERSION)};
  module->initialize();
  return module;
}

// Throws GridFileError, `what` named: the file, or what is asked for.
const VdbModule& loaded(const std::string& what) {
  static const auto module = load_module();
  if (const auto* refusal = std::get_if<VdbRefusal>(&module))
    throw GridFileError(fmt::format("{}: {}", what, refusal->why));
  return *std::get<const VdbModule*>(module);
}

}  // namespace

bool has_openvdb() { return true; }

std::string openvdb_version() { return loaded("OpenVDB's version").openvdb_version; }

VdbGrids read_vdb(const std::string& path, const VdbRequest& request) {
  const std::uint64_t size = size_of_vdb_file(path);
  return read_in_child(loaded(path), path, size, request);
}

void write_vdb(const std::string& path, const Voxels& voxels, Vec3<double> voxel_size) {
  const auto answer = loaded(path).write(path, voxels, voxel_size);
  if (const auto* refusal = std::get_if<VdbRefusal>(&answer)) throw GridFileError(refusal->why);
}

LevelSetMeasure measure_level_set(std::span<const Vec3<double>> centres, double radius,
                                  double voxel, Vec3<double> size) {
  const auto answer =
      loaded("the level set of spheres").measure_level_set(centres, radius, voxel, size);
  if (const auto* refusal = std::get_if<VdbRefusal>(&answer)) throw GridFileError(refusal->why);
  return std::get<LevelSetMeasure>(answer);
}

}  // namespace lamella
