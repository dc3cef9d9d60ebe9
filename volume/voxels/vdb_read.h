#pragma once

#include <cstdint>
#include <string>

#include "volume/voxels/vdb_module.h"

namespace lamella {

/// Bytes of the file. Throws GridFileError for what is no regular file that can be read: a pipe or
/// a device may have no end.
[[nodiscard]] std::uint64_t size_of_vdb_file(const std::string& path);

/// What the module reads, in a child process with the memory and time that a file of `size` bytes
/// may take. Throws GridFileError, file named.
[[nodiscard]] VdbGrids read_in_child(const VdbModule& module, const std::string& path,
                                     std::uint64_t size, const VdbRequest& request);

}  // namespace lamella
