#pragma once

#include <filesystem>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// Whether a grid is a file, and not one of the built-in grids.
[[nodiscard]] bool is_file(const GridReference& grid);

/// The path of a grid's file from the working directory. Not of a built-in grid.
[[nodiscard]] std::filesystem::path path_of(const GridReference& grid);

/// The files that a stack names, from the working directory, in the order of the layers.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const Stack& stack);

/// The path of `file` as it is named in a text that lies in `folder`: relative, with symbolic
/// links of the folders (not of the file) resolved, so that ".." leads where the system goes.
/// `folder` need not exist; empty: the working directory.
[[nodiscard]] std::filesystem::path relative_to(const std::filesystem::path& file,
                                                const std::filesystem::path& folder);

/// The same stack, with its files named for a text that lies in `folder`: whoever moves both
/// together finds them again.
[[nodiscard]] Stack with_files_relative_to(Stack stack, const std::filesystem::path& folder);

}  // namespace lamella
