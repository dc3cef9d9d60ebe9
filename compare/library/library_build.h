#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "compare/library/library_index.h"

namespace lamella {

struct LibraryBuild {
  std::filesystem::path folder{};
  std::vector<std::string> only{};  ///< names of entries; empty: all
  ReferenceEffort effort{};
  /// Told of every entry once it is there: its number among `of` entries, and whether it was kept.
  std::function<void(const LibraryEntry&, std::size_t number, std::size_t of, bool kept)> done{};
};

struct LibraryBuildResult {
  std::size_t kept = 0, found = 0;
  std::vector<std::string> refused{};  ///< "NAME: why": what this build cannot simulate
  bool interrupted = false;
  std::uint64_t bytes = 0;  ///< of all entries in the folder
};

/// Finds the entries that are not there yet, one after the other; the index is written after each,
/// so that the same call goes on wherever the last one was ended. An entry is kept if its stack,
/// grid and version of the program are the same and its files are whole. Throws UsageError,
/// OutputError, FolderInUse.
[[nodiscard]] LibraryBuildResult build_library(const LibraryBuild& build,
                                               const RunMonitor& monitor);

}  // namespace lamella
