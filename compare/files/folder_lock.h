#pragma once

#include <filesystem>
#include <stdexcept>

namespace lamella {

/// Another run works in the folder: what() names the folder, and the other's process and host.
struct FolderInUse : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Keeps other runs out of an output folder for as long as it lives.
///
/// A file ".lamella-lock" in the folder is locked (flock) and tells who holds it. The system gives
/// the lock back when a process ends, however it ends, so a file that a killed run left behind
/// stops nobody. It is removed at the end. Where the file system has no locks, a warning says so
/// and the run goes on.
class FolderLock {
 public:
  /// `folder` exists. Throws FolderInUse, or OutputError where the file cannot be made.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace lamella
