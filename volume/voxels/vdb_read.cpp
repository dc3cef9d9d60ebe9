#include "volume/voxels/vdb_read.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "phase/parameters/one_line.h"
#include "volume/voxels/bounded_child.h"
#include "volume/voxels/voxel_message.h"

namespace lamella {
namespace {

// What OpenVDB may take for a file. A leaf without active voxels is 129 bytes there and 6144 in
// memory where its values are vectors, an internal node of 16^3 or 32^3 empty tiles as much less:
// 64 times the file, and our own copy. A megabyte of leaves that compress well is ten million
// voxels, which take about a second.
ChildLimits limits_for(std::uint64_t bytes) {
  const double megabytes = static_cast<double>(bytes) / (1 << 20);
  const double processor = 4 * (1 + megabytes);
  return {.memory = (std::uint64_t{1} << 30) + 128 * bytes,
          .processor_seconds = processor,
          .seconds = 10 * processor};
}

}  // namespace

std::uint64_t size_of_vdb_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0)
    throw GridFileError(fmt::format("{}: {}; allowed: a .vdb file", path, std::strerror(errno)));
  if (S_ISDIR(status.st_mode))
    throw GridFileError(fmt::format("{}: is a directory; allowed: a .vdb file", path));
  if (!S_ISREG(status.st_mode))
    throw GridFileError(fmt::format("{}: is no regular file; allowed: a .vdb file", path));
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0)
    throw GridFileError(fmt::format("{}: {}; allowed: a .vdb file", path, std::strerror(errno)));
  ::close(file);
  return static_cast<std::uint64_t>(status.st_size);
}

VdbGrids read_in_child(const VdbModule& module, const std::string& path, std::uint64_t size,
                       const VdbRequest& request) {
  try {
    const std::string message = run_in_child(limits_for(size), [&](ChildAnswer& answer) {
      const auto grids = module.read(path, request);
      if (const auto* refusal = std::get_if<VdbRefusal>(&grids)) throw GridFileError(refusal->why);
      write_message(std::get<VdbGrids>(grids),
                    [&](const void* data, std::size_t count) { answer.write(data, count); });
    });
    VdbGrids grids = read_message(message);
    for (std::string& warning : grids.warnings) warning = path + ": " + warning;
    return grids;
  } catch (const ChildRefusal& refusal) {
    throw GridFileError(fmt::format("{}: {}", path, one_line(refusal.what(), 4000)));
  } catch (const ChildFailure& failure) {
    throw GridFileError(
        fmt::format("{}: found no readable .vdb file (OpenVDB {}); allowed: a .vdb file", path,
                    failure.what()));
  } catch (const GridFileError& error) {
    throw GridFileError(fmt::format("{}: {}", path, error.what()));
  }
}

}  // namespace lamella
