#include "compare/files/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace lamella {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const char* action, const fs::path& path, const std::error_code& reason) {
  throw OutputError(fmt::format("cannot {} {}: {}", action, path.string(), reason.message()));
}

std::error_code last_error() { return {errno, std::generic_category()}; }

/// An open file that is closed, and removed unless it was kept.
class OpenFile {
 public:
  OpenFile(int descriptor, fs::path remove_on_failure)
      : descriptor_(descriptor), remove_on_failure_(std::move(remove_on_failure)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!remove_on_failure_.empty()) ::unlink(remove_on_failure_.c_str());
  }

  [[nodiscard]] std::error_code write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return last_error();
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return {};
  }
  /// What was written is on the disk, or the system says why not.
  [[nodiscard]] std::error_code sync() {
    while (::fsync(descriptor_) != 0) {
      if (errno == EINTR) continue;
      // Some file systems have nothing to do.
      return errno == EINVAL || errno == ENOSYS || errno == ENOTSUP ? std::error_code()
                                                                    : last_error();
    }
    return {};
  }
  /// Some file systems tell of a full disk only now.
  [[nodiscard]] std::error_code close() {
    return ::close(std::exchange(descriptor_, -1)) == 0 ? std::error_code() : last_error();
  }
  void keep() { remove_on_failure_.clear(); }

 private:
  int descriptor_;
  fs::path remove_on_failure_;
};

/// A name that no other thread or process uses, whatever the length of the final one.
fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  return path.parent_path() / fmt::format(".lamella-{}-{}.tmp", ::getpid(), counter++);
}

using Content = std::function<void(const AddBytes& add)>;

void write_content(OpenFile& file, const fs::path& path, const Content& content) {
  content([&](std::string_view bytes) {
    if (const auto error = file.write(bytes)) fail("write", path, error);
  });
}

void write_in_place(const fs::path& path, const Content& content) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) fail("write", path, last_error());
  OpenFile file(descriptor, {});
  write_content(file, path, content);
  if (const auto error = file.close()) fail("write", path, error);
}

/// The new name is on the disk, too; a system that cannot say so has the file all the same.
void sync_folder(const fs::path& of_file) {
  const fs::path folder = of_file.has_parent_path() ? of_file.parent_path() : fs::path(".");
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

void write_and_rename(const fs::path& path, const Content& content) {
  fs::path temporary;
  int descriptor = -1;
  do {
    temporary = temporary_beside(path);
    descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EEXIST);
  if (descriptor < 0) fail("write", path, last_error());
  OpenFile file(descriptor, temporary);
  write_content(file, path, content);
  if (const auto error = file.sync()) fail("write", path, error);
  if (const auto error = file.close()) fail("write", path, error);
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail("write", path, last_error());
  file.keep();
  sync_folder(path);
}

}  // namespace

void make_output_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::file_status status = fs::status(folder);
  if (fs::exists(status) && !fs::is_directory(status))
    throw OutputError(
        fmt::format("cannot use {} as a folder: it is a file or device", folder.string()));
  if (error) fail("make folder", folder, error);
  if (::access(folder.c_str(), W_OK | X_OK) != 0) fail("write to folder", folder, last_error());
}

void check_output_file(const fs::path& path) {
  const fs::file_status status = fs::status(path);
  if (fs::is_directory(status))
    fail("write", path, std::make_error_code(std::errc::is_a_directory));
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (fs::exists(status) && ::access(path.c_str(), W_OK) != 0) fail("write", path, last_error());
  if (fs::exists(status) && !fs::is_regular_file(status)) return;
  if (fs::exists(parent) && !fs::is_directory(parent))
    fail("write", path, std::make_error_code(std::errc::not_a_directory));
  if (::access(parent.c_str(), W_OK | X_OK) != 0) fail("write", path, last_error());
}

void write_file(const fs::path& path, std::string_view bytes) {
  write_file(path, [bytes](const AddBytes& add) { add(bytes); });
}

void write_file(const fs::path& path, const Content& content) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status))
    fail("write", path, std::make_error_code(std::errc::is_a_directory));
  if (!fs::exists(status)) return write_and_rename(path, content);
  // A rename would pass over a file's own write protection.
  if (::access(path.c_str(), W_OK) != 0) fail("write", path, last_error());
  if (!fs::is_regular_file(status)) return write_in_place(path, content);
  const fs::path target = fs::canonical(path, error);
  write_and_rename(error ? path : target, content);
}

}  // namespace lamella
