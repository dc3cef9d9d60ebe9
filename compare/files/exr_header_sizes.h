#pragma once

#include <filesystem>

namespace lamella {

/// Throws std::runtime_error where an attribute in a header of an OpenEXR file claims more bytes
/// than the file has, for which the library would ask memory before it reads, or others than its
/// type has, so that the library would lose its place. What is no OpenEXR file is left to it.
void check_exr_header_sizes(const std::filesystem::path& path);

}  // namespace lamella
