#pragma once

#include <filesystem>

namespace lamella {

/// Throws std::runtime_error where an attribute in a header of an OpenEXR file claims more bytes
/// than the file has: the library asks for that memory before it reads. What is no OpenEXR file is
/// left to the library.
void check_exr_header_sizes(const std::filesystem::path& path);

}  // namespace lamella
