#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compare/samples/stack_design.h"
#include "compare/shards/shard.h"

namespace lamella {

class FileLock;
class LineFile;

/// What the making of a stack's file tells of it, for the index.
struct MadeFile {
  nlohmann::ordered_json about;  ///< "walks", "rows", ...
  bool whole = true;             ///< false: it was interrupted, and there is no file
};

/// A data set on disk, a file per stack in one folder, beside:
///
///     settings.json   what the files depend on; a folder holds one set
///     done-I-of-N.jsonl   a line per file that is whole: the work of one process
///     index.json      all that are there, in the order of the stacks
///
/// A set that was ended, by Ctrl-C or by any other way, goes on where the same command runs again:
/// files are written whole, then their lines. Processes with different parts may share the folder.
class SampleSet {
 public:
  /// Makes the folder, or finds one with the same settings. Throws UsageError where it holds
  /// another set, OutputError, FolderInUse where a process does the same part.
  SampleSet(std::filesystem::path folder, const nlohmann::ordered_json& settings,
            std::vector<DesignedStack> stacks, Shard part);
  ~SampleSet();

  /// Makes the files of this part that are missing, in order, until `stop` says so; make(k, file)
  /// writes that of stack k. tell(k, entry, was_there): after each.
  void make(const std::function<MadeFile(std::size_t, const std::filesystem::path&)>& make,
            const std::function<void(std::size_t, const nlohmann::ordered_json&, bool)>& tell,
            const std::function<bool()>& stop);

  /// The files of this part that are missing, in order.
  [[nodiscard]] std::vector<std::uint64_t> missing() const;
  /// Takes the entry of a file that another process made in this folder, and tells it on the disk.
  /// Throws UsageError where the file is not seen from here.
  void keep(std::uint64_t k, nlohmann::ordered_json entry);

  /// Writes index.json, and returns it. `header`: what comes first.
  nlohmann::ordered_json write_index(nlohmann::ordered_json header) const;
  [[nodiscard]] std::size_t done() const;
  [[nodiscard]] std::size_t count() const { return stacks_.size(); }

 private:
  void read_lines();
  void begin_lines();

  std::filesystem::path folder_;
  std::vector<DesignedStack> stacks_;
  Shard part_;
  std::unique_ptr<FileLock> lock_;
  std::unique_ptr<LineFile> lines_;
  std::vector<nlohmann::ordered_json> entries_;  // null: not done
};

/// The entry of a file that `made` tells of, which lies in the folder.
[[nodiscard]] nlohmann::ordered_json set_entry(const std::filesystem::path& folder, std::uint64_t k,
                                               const DesignedStack& stack, const MadeFile& made);
/// Its name.
[[nodiscard]] std::string set_file_name(const DesignedStack& stack);

}  // namespace lamella
