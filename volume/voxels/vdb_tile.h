#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "volume/voxels/vdb_request.h"

namespace lamella {

/// The tile in the index space of the density grid.
struct VdbTile {
  openvdb::CoordBBox box;
  std::string source;                 ///< where it comes from, for people
  std::vector<std::string> warnings;  ///< one line each

  [[nodiscard]] VoxelExtent extent() const {
    const openvdb::Coord d = box.dim();
    return {{d.x(), d.y(), d.z()}};
  }
};

/// Name of the metadata in which write_vdb notes the tile, Vec3i: voxels from index 0 on.
inline constexpr char kExtentKey[] = "lamella_voxels";

/// The voxels of the tile: those that the request names, else those of the file's metadata, else
/// the size in mm over the file's voxel size if the active voxels lie in it, else the bounding box
/// of the active voxels. Throws GridFileError.
[[nodiscard]] VdbTile tile_of(const openvdb::FloatGrid& density, const std::string& name,
                              const openvdb::MetaMap& file, const VdbRequest& request);

/// Edges of a voxel, and where index 0 lies, in the file's units. Throws GridFileError unless the
/// transform scales by positive numbers and moves.
struct VdbLattice {
  std::array<double, 3> scale{}, origin{};
};
[[nodiscard]] VdbLattice lattice_of(const openvdb::GridBase& grid, const std::string& name);

/// Index of another grid's voxel that holds the middle of density voxel i:
/// floor(scale i + shift), per axis.
struct VdbIndexMap {
  std::array<double, 3> scale{1, 1, 1}, shift{0.5, 0.5, 0.5};

  [[nodiscard]] openvdb::Coord operator()(const openvdb::Coord& i) const;
  /// The step from the density's index to the other grid's, where both have the same voxels.
  [[nodiscard]] std::optional<openvdb::Coord> offset() const;
};

/// `tile`: of the density; `box`: the voxels that the other grid has something in.
///
/// Files do not say whether index i is a voxel's middle (OpenVDB's own convention) or its lower
/// corner (arrays scaled by their voxel size). With one voxel size it does not matter. Else it is
/// the convention that makes the boxes of both grids coincide, if one does, then the one that makes
/// faces of the larger voxels faces of the smaller ones, then the middle.
[[nodiscard]] VdbIndexMap index_map(const VdbLattice& density, const openvdb::CoordBBox& tile,
                                    const VdbLattice& other, const openvdb::CoordBBox& box);

/// The box that metadata of known programs give, or nothing.
struct NotedBox {
  openvdb::CoordBBox box;
  std::string key;
};
[[nodiscard]] std::optional<NotedBox> noted_box(const openvdb::GridBase& grid,
                                                const openvdb::MetaMap& file);

}  // namespace lamella
