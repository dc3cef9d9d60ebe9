#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/library/reference_lobes.h"

namespace lamella {

/// A file of an entry, right in the folder of the library.
struct EntryFile {
  std::string name;  ///< NAME.npz, NAME.exr or NAME.csv
  std::uint64_t bytes = 0;
  std::string sha256{};
};

/// An entry as index.json has it.
struct LibraryEntry {
  std::string name, group, about, source;
  std::string stack;    ///< TOML, every default filled in
  std::string version;  ///< of the program that found it
  int channels = 1;
  std::string grid;  ///< "8x16"
  std::uint64_t seed = 1;
  ReferenceMethod lobes{}, points{};
  std::size_t pairs = 0;  ///< points
  double seconds = 0;     ///< that it took
  std::vector<EntryFile> files{};
};

/// The index of a library, a folder: what index.json says.
struct LibraryIndex {
  std::vector<LibraryEntry> entries{};

  [[nodiscard]] const LibraryEntry* find(const std::string& name) const;
};

inline constexpr char kIndexName[] = "index.json";

/// Reads FOLDER/index.json; it is untrusted: names are names of files in the folder, the content of
/// files is held against their hashes when it is read. Throws UsageError.
[[nodiscard]] LibraryIndex read_index(const std::filesystem::path& folder);

/// The same of a text that is there already; `file`: as named in errors.
[[nodiscard]] LibraryIndex index_from(const std::string& text, const std::string& file);

/// The text of index.json.
[[nodiscard]] std::string to_text(const LibraryIndex& index);

/// Why a file of the entry is not what the index says: missing, another size, another content;
/// nothing where all are whole.
[[nodiscard]] std::optional<std::string> why_not_whole(const LibraryEntry& entry,
                                                       const std::filesystem::path& folder);

/// The lobes and points of an entry, from NAME.npz. Throws UsageError where the file is damaged.
[[nodiscard]] Reference read_reference(const LibraryEntry& entry,
                                       const std::filesystem::path& folder);

/// The stack of an entry. Throws UsageError or StackFileError.
[[nodiscard]] Stack stack_of_entry(const LibraryEntry& entry);

/// Throws UsageError where a name is none of `allowed`, with a suggestion.
void check_names(const std::vector<std::string>& names, const std::vector<std::string>& allowed,
                 const std::string& option);

}  // namespace lamella
