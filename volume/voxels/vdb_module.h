#pragma once

#include <span>
#include <string>
#include <variant>

#include "phase/math/vec3.h"
#include "volume/voxels/vdb_request.h"
#include "volume/voxels/voxels.h"

namespace lamella {

/// File name and symbol of the module that holds all use of OpenVDB. It is a shared object of its
/// own, which is loaded at the first .vdb file: the dynamic linker takes 25 ms to relocate OpenVDB.
inline constexpr char kVdbModuleFile[] = "lamella_openvdb.so";
inline constexpr char kVdbModuleSymbol[] = "lamella_vdb_module";

/// Why a call of the module was refused: the text of a GridFileError. It crosses the border of the
/// module as a value, since exceptions of hidden types need not be recognised beyond it.
struct VdbRefusal {
  std::string why;
};

/// What the module offers. The functions may throw std::bad_alloc and nothing else.
struct VdbModule {
  const char* lamella_version;  ///< of the build; another build's module is refused
  const char* openvdb_version;
  /// Fills OpenVDB's registry of types; to be called before a fork that reads.
  void (*initialize)();
  /// Reads the grids that are wanted, without the file's name in what is refused. For a process
  /// that ends after reading (see VdbArchive).
  std::variant<VdbGrids, VdbRefusal> (*read)(const std::string& path, const VdbRequest& request);
  std::variant<std::monostate, VdbRefusal> (*write)(const std::string& path, const Voxels& voxels,
                                                    Vec3<double> voxel_size);
  std::variant<LevelSetMeasure, VdbRefusal> (*measure_level_set)(
      std::span<const Vec3<double>> centres, double radius, double voxel, Vec3<double> size);
};

}  // namespace lamella
