#pragma once

#include "volume/voxels/vdb_archive.h"
#include "volume/voxels/vdb_request.h"

namespace lamella {

/// The grids that are wanted, by name, as fields of the density's voxels. Throws GridFileError,
/// grid and voxel named, without the file's name.
[[nodiscard]] VdbGrids read_fields(VdbArchive& archive, const VdbRequest& request);

}  // namespace lamella
