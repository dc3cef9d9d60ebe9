#pragma once

#include <filesystem>
#include <stdexcept>

namespace lamella {

/// Another run works in the folder, or on the file: what() names it, and the other's process and
/// host.
struct FolderInUse : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Keeps other runs out of an output folder, or away from a file, for as long as it lives.
///
/// A file ".lamella-lock" in the folder, or ".NAME.lamella-lock" beside the file, is locked (flock)
/// and tells who holds it. The system gives the lock back when a process ends, however it ends, so
/// a file that a killed run left behind stops nobody. It is removed at the end. Where the file
/// system has no locks, a warning says so and the run goes on.
class FolderLock {
 public:
  /// `folder` exists. Throws FolderInUse, or OutputError where the file cannot be made.
  explicit FolderLock(const std::filesystem::path& folder)
      : FolderLock(folder, folder / ".lamella-lock", "works in this folder", "-o with a folder") {}
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

 protected:
  FolderLock(const std::filesystem::path& locked, std::filesystem::path lock,
             const char* what_it_does, const char* other);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// The same of a file, which need not exist; its folder does.
class FileLock : public FolderLock {
 public:
  explicit FileLock(const std::filesystem::path& file);
};

}  // namespace lamella
