#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "compare/files/output_error.h"

namespace lamella {

/// Makes a folder with its parents, or takes one that is there. Throws OutputError where it is no
/// folder, cannot be made or cannot be written to.
void make_output_folder(const std::filesystem::path& folder);

/// Throws OutputError where write_file would, so that long work does not fail at its end.
void check_output_file(const std::filesystem::path& path);

/// The file whose name a new one takes in order to be `path`: a symbolic link is followed; empty
/// for a pipe or a device, which are written to directly. Throws OutputError for what cannot be
/// written.
[[nodiscard]] std::filesystem::path written_path(const std::filesystem::path& path);

/// Writes a whole file, text or binary: a reader sees the old content or the new, never a part,
/// even where the power fails. The bytes go to a temporary name in the same folder, are synced to
/// the disk, and then the name takes the file's place; on failure it is removed. A symbolic link is
/// followed; a pipe or a device is written to directly. Throws OutputError.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// The same of content that comes piece by piece, so that it need not be in memory as a whole:
/// `content` hands the pieces to the function that it is given.
using AddBytes = std::function<void(std::string_view bytes)>;
void write_file(const std::filesystem::path& path,
                const std::function<void(const AddBytes& add)>& content);

}  // namespace lamella
