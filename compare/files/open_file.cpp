#include "compare/files/open_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <utility>

#include "compare/files/output_error.h"

namespace lamella {

namespace fs = std::filesystem;

void fail_at(const char* action, const fs::path& path, const std::error_code& reason) {
  throw OutputError(fmt::format("cannot {} {}: {}", action, path.string(), reason.message()));
}

std::error_code last_system_error() { return {errno, std::generic_category()}; }

OpenFile::OpenFile(int descriptor, fs::path remove_on_failure)
    : descriptor_(descriptor), remove_on_failure_(std::move(remove_on_failure)) {}

OpenFile::OpenFile(OpenFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      remove_on_failure_(std::exchange(other.remove_on_failure_, {})) {}

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!remove_on_failure_.empty()) ::unlink(remove_on_failure_.c_str());
}

std::error_code OpenFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return last_system_error();
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

std::error_code OpenFile::sync() {
  while (::fsync(descriptor_) != 0) {
    if (errno == EINTR) continue;
    // Some file systems have nothing to do.
    return errno == EINVAL || errno == ENOSYS || errno == ENOTSUP ? std::error_code()
                                                                  : last_system_error();
  }
  return {};
}

std::error_code OpenFile::close() {
  return ::close(std::exchange(descriptor_, -1)) == 0 ? std::error_code() : last_system_error();
}

TemporaryFile temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  for (;;) {
    // Short, whatever the length of the final one.
    fs::path name = path.parent_path() / fmt::format(".lamella-{}-{}.tmp", ::getpid(), counter++);
    const int descriptor = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) return {name, OpenFile(descriptor, name)};
    if (errno != EEXIST) fail_at("write", path, last_system_error());
  }
}

namespace {

/// The new name is on the disk, too; a system that cannot say so has the file all the same.
void sync_folder(const fs::path& of_file) {
  const fs::path folder = of_file.has_parent_path() ? of_file.parent_path() : fs::path(".");
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

void take_name(OpenFile& file, const fs::path& temporary, const fs::path& path) {
  if (const auto error = file.sync()) fail_at("write", path, error);
  if (const auto error = file.close()) fail_at("write", path, error);
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail_at("write", path, last_system_error());
  file.keep();
  sync_folder(path);
}

}  // namespace lamella
