#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace lamella {

/// Throws OutputError: "cannot ACTION PATH: the system's reason".
[[noreturn]] void fail_at(const char* action, const std::filesystem::path& path,
                          const std::error_code& reason);
/// The error of the last call of the system.
[[nodiscard]] std::error_code last_system_error();

/// An open file that is closed, and removed unless it was kept.
class OpenFile {
 public:
  OpenFile() = default;
  OpenFile(int descriptor, std::filesystem::path remove_on_failure);
  OpenFile(OpenFile&& other) noexcept;
  OpenFile& operator=(OpenFile&&) = delete;
  ~OpenFile();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] std::error_code write(std::string_view bytes);
  /// What was written is on the disk, or the system says why not.
  [[nodiscard]] std::error_code sync();
  /// Some file systems tell of a full disk only now.
  [[nodiscard]] std::error_code close();
  void keep() { remove_on_failure_.clear(); }

 private:
  int descriptor_ = -1;
  std::filesystem::path remove_on_failure_;
};

/// A new file to write and read, beside `path`, under a name that no other thread or process uses.
/// Throws OutputError.
struct TemporaryFile {
  std::filesystem::path name;
  OpenFile file;
};
[[nodiscard]] TemporaryFile temporary_beside(const std::filesystem::path& path);

/// Gives a temporary file, closed and synced, the name `path`. Throws OutputError.
void take_name(OpenFile& file, const std::filesystem::path& temporary,
               const std::filesystem::path& path);

}  // namespace lamella
