#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compare/files/open_file.h"

namespace lamella {

/// Bytes that grow: in memory up to kMostKept, then in a file without a name, beside `path`, which
/// the system removes however the process ends.
class NamelessFile {
 public:
  static constexpr std::uint64_t kMostKept = std::uint64_t{64} << 20;

  /// Throws OutputError, as do all.
  explicit NamelessFile(std::filesystem::path path) : path_(std::move(path)) {}

  void append(std::string_view bytes);
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Hands all bytes to `take`, piece by piece.
  void each_piece(const std::function<void(std::string_view)>& take) const;
  /// Its content is gone, and its room is free.
  void close();

 private:
  [[noreturn]] void fail() const;
  void move_to_disk();

  std::filesystem::path path_;
  std::vector<std::string> kept_;
  std::optional<OpenFile> file_;
  std::uint64_t size_ = 0;
};

/// A file that is written bit by bit and takes its name when all is there, like write_file.
class StreamedFile {
 public:
  /// Throws OutputError, as do all.
  explicit StreamedFile(std::filesystem::path path);

  void write(std::string_view bytes);
  /// All of another file.
  void append(const NamelessFile& file);
  /// Syncs and renames. Returns the size in bytes.
  [[nodiscard]] std::uint64_t finish();

 private:
  std::filesystem::path path_, target_;
  std::optional<TemporaryFile> temporary_;  // none: a pipe or a device
  OpenFile direct_;
  std::uint64_t size_ = 0;

  [[nodiscard]] OpenFile& file() { return temporary_ ? temporary_->file : direct_; }
};

}  // namespace lamella
