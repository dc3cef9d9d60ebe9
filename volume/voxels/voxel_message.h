#pragma once

#include <functional>
#include <string_view>

#include "volume/voxels/vdb_request.h"

namespace lamella {

/// Takes bytes of a message.
using MessageSink = std::function<void(const void*, std::size_t)>;

/// The voxels read from a grid file, as bytes for another process on this machine, block by block.
void write_message(const VdbGrids& grids, const MessageSink& sink);

/// Reads it back. The sender may have been damaged by the file it read: every count and every value
/// is checked. Throws GridFileError.
[[nodiscard]] VdbGrids read_message(std::string_view bytes);

}  // namespace lamella
