#include "compare/files/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "compare/files/output_folder.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

std::string reason(int error) { return std::generic_category().message(error); }

std::string this_host() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

/// What the holder wrote: "pid N on host H". It may not have come to that yet.
std::string holder_of(int descriptor) {
  std::array<char, 512> text{};
  const ssize_t size = ::pread(descriptor, text.data(), text.size(), 0);
  std::string holder(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  holder = holder.substr(0, holder.find('\n'));
  return holder.empty() ? "which has just begun" : holder;
}

/// Whether the path still leads to the open file: its last holder may have removed it meanwhile.
bool is_still_there(int descriptor, const fs::path& path) {
  struct stat open {};
  struct stat named {};
  return ::fstat(descriptor, &open) == 0 && ::stat(path.c_str(), &named) == 0 &&
         open.st_ino == named.st_ino && open.st_dev == named.st_dev;
}

}  // namespace

FolderLock::FolderLock(const fs::path& locked, fs::path lock, const char* what_it_does,
                       const char* other)
    : path_(std::move(lock)) {
  while (true) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw OutputError(fmt::format("cannot write {}: {}", path_.string(), reason(errno)));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) {
      if (is_still_there(descriptor_, path_)) break;
    } else if (errno == EWOULDBLOCK) {
      const std::string holder = holder_of(descriptor_);
      ::close(descriptor_);
      throw FolderInUse(
          fmt::format("{}: another run, {}, {}; allowed: to wait for its end, or {} of its own",
                      locked.string(), holder, what_it_does, other));
    } else if (errno != EINTR) {
      fmt::print(stderr,
                 "lamella: warning: {}: its file system has no locks ({}): see to it that no other "
                 "run works there\n",
                 locked.string(), reason(errno));
      break;
    }
    ::close(descriptor_);
  }
  const std::string text = fmt::format("pid {} on host {}\n", ::getpid(), this_host());
  // The text is for people: a full disk is told by what is written next.
  if (::ftruncate(descriptor_, 0) == 0) [[maybe_unused]]
    const ssize_t written = ::pwrite(descriptor_, text.data(), text.size(), 0);
}

FolderLock::~FolderLock() {
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

FileLock::FileLock(const std::filesystem::path& file)
    : FolderLock(file,
                 file.parent_path() / fmt::format(".{}.lamella-lock", file.filename().string()),
                 "works on this file", "a file") {}

}  // namespace lamella
