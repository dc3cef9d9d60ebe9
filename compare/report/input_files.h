#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// The files that a run reads beside its stack file: density grids, models in shared objects. Their
/// content is hashed when this is made, before the run reads them.
class InputFiles {
 public:
  InputFiles() = default;
  /// `models`: paths of shared objects. A file that is not there is left for its reader to tell.
  /// Throws OutputError where a file cannot be read.
  explicit InputFiles(const Stack& stack, const std::vector<std::filesystem::path>& models = {});

  [[nodiscard]] bool empty() const { return files_.empty(); }

  /// Throws OutputError where a file's content is no longer the one that was hashed, so that the
  /// content which the run read is unknown.
  void check() const;

  /// A line per file as the program sha256sum writes and checks it: hash, two blanks, and the name
  /// as a text in `folder` has it (relative_to).
  [[nodiscard]] std::string text(const std::filesystem::path& folder) const;
  /// The files as a list of {name, sha256}.
  [[nodiscard]] nlohmann::ordered_json json(const std::filesystem::path& folder) const;

 private:
  struct File {
    std::filesystem::path path;
    std::string hash;
    std::string stamp;  // size and times: as long as they stay, the content is not read again
  };
  std::vector<File> files_{};  // each path once
};

/// Finds a file that a text in `folder` names, by the record that InputFiles::text made: the file
/// of that name, or else one of the same last name right in `folder`, if its content has the
/// recorded hash. A file without a record is found by its name alone. Throws StackFileError, which
/// begins with `where` and names the file, where no file is found or the content is another.
[[nodiscard]] std::filesystem::path find_recorded(const std::string& name,
                                                  const std::string& recorded,
                                                  const std::filesystem::path& folder,
                                                  const std::string& where);

/// A stack of such a text, with its grids where find_recorded finds their files.
[[nodiscard]] Stack with_found_files(Stack stack, const std::string& recorded,
                                     const std::filesystem::path& folder, const std::string& where);

}  // namespace lamella
