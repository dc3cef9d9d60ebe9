#pragma once

#include <string>

namespace lamella {

/// Puts a digest of a .vdb file's other bytes into the place of the identifier (UUID, 36
/// characters after the version numbers) that OpenVDB draws at random for every file that it
/// writes: equal grids make equal files then. Throws
/// std::runtime_error.
void set_identity_by_content(const std::string& path);

}  // namespace lamella
