#include "volume/voxels/vdb_archive.h"

#include <fmt/format.h>
#include <openvdb/io/GridDescriptor.h>

#include <algorithm>

#include "phase/parameters/one_line.h"
#include "volume/voxels/vdb_request.h"

namespace lamella {
namespace {

constexpr std::uint32_t kLongestName = 4096;
constexpr char kHalfSuffix[] = "_HalfFloat";

[[noreturn]] void refuse(const std::string& found) {
  throw GridFileError(fmt::format("found {}; allowed: a .vdb file", found));
}

// A name as OpenVDB writes it: 32 bits of length, bytes.
std::string read_name(std::istream& in) {
  std::uint32_t length = 0;
  in.read(reinterpret_cast<char*>(&length), sizeof length);
  if (length > kLongestName) refuse(fmt::format("a name of {} bytes", length));
  std::string name(length, ' ');
  in.read(name.data(), length);
  return name;
}

std::int64_t read_place(std::istream& in) {
  std::int64_t place = 0;
  in.read(reinterpret_cast<char*>(&place), sizeof place);
  return place;
}

// See VdbArchive: nothing that has been begun is destroyed.
openvdb::GridBase::Ptr kept(openvdb::GridBase::Ptr grid) {
  static auto& all = *new std::vector<openvdb::GridBase::Ptr>;
  all.push_back(grid);
  return grid;
}

}  // namespace

void initialize_openvdb() {
  static const bool done = [] {
    openvdb::initialize();
    return true;
  }();
  (void)done;
}

// Runs f; exceptions of the library and of the stream become ours.
template <class F>
auto VdbArchive::watched(const F& f) -> decltype(f()) {
  try {
    return f();
  } catch (const GridFileError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::ios_base::failure&) {
    refuse(
        fmt::format("no whole .vdb file: it ends after {} bytes, and goes on from there", size_));
  } catch (const std::exception& error) {
    refuse(fmt::format("no readable .vdb file ({})", one_line(error.what())));
  }
}

VdbArchive::VdbArchive(const std::string& path) : stream_(path, std::ios::binary) {
  watched([&] {
    stream_.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
    stream_.seekg(0, std::ios::end);
    size_ = static_cast<std::int64_t>(stream_.tellg());
    stream_.seekg(0);
    open();
    if (inputHasGridOffsets())
      list();
    else
      read_all();
  });
}

// As io::File::open does it.
void VdbArchive::open() {
  readHeader(stream_);
  stream_metadata_.reset(new openvdb::io::StreamMetadata);
  stream_metadata_->setSeekable(true);
  openvdb::io::setStreamMetadataPtr(stream_, stream_metadata_, /*transfer=*/false);
  setFormatVersion(stream_);
  setLibraryVersion(stream_);
  setDataCompression(stream_);
  metadata_.readMeta(stream_);
}

void VdbArchive::list() {
  const std::int32_t count = readGridCount(stream_);
  for (std::int32_t k = 0; k < count; ++k) {
    Entry entry;
    entry.descriptor = static_cast<std::int64_t>(stream_.tellg());
    entry.unique_name = read_name(stream_);
    entry.name = openvdb::io::GridDescriptor::stripSuffix(entry.unique_name);
    entry.type = read_name(stream_);
    if (entry.type.ends_with(kHalfSuffix))
      entry.type.resize(entry.type.size() - (sizeof kHalfSuffix - 1));
    if (fileVersion() >= openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING)
      entry.parent = read_name(stream_);
    entry.grid = read_place(stream_);
    const std::int64_t blocks = read_place(stream_);
    entry.end = read_place(stream_);
    const auto place = static_cast<std::int64_t>(stream_.tellg());
    const bool in_order =
        place <= entry.grid && entry.grid <= entry.end && (blocks == 0 || blocks <= entry.end);
    if (!in_order)
      refuse(fmt::format("grid \"{}\" at bytes {} to {} of the file, described at {}",
                         one_line(entry.name), entry.grid, entry.end, entry.descriptor));
    if (entry.end > size_)
      refuse(fmt::format("no whole .vdb file: grid \"{}\" ends at byte {}, the file at byte {}",
                         one_line(entry.name), entry.end, size_));
    stream_.seekg(entry.end);
    entries_.push_back(std::move(entry));
  }
}

// A file that io::Stream wrote tells no places: each grid begins where the one before it ends, so
// that all must be read, and a type that OpenVDB does not know ends the file.
void VdbArchive::read_all() {
  const std::int32_t count = readGridCount(stream_);
  for (std::int32_t k = 0; k < count; ++k) {
    openvdb::io::GridDescriptor descriptor;
    auto grid = kept(descriptor.read(stream_));
    readGrid(grid, descriptor, stream_);
    entries_.push_back({.name = descriptor.gridName(),
                        .unique_name = descriptor.uniqueName(),
                        .type = descriptor.gridType(),
                        .parent = descriptor.instanceParentName()});
    streamed_.push_back(std::move(grid));
  }
}

openvdb::GridBase::Ptr VdbArchive::read_whole(const Entry& entry) {
  if (!streamed_.empty()) return streamed_[static_cast<std::size_t>(&entry - entries_.data())];
  stream_.seekg(entry.descriptor);
  openvdb::io::GridDescriptor descriptor;
  auto grid = kept(descriptor.read(stream_));
  stream_.seekg(entry.grid);
  readGrid(grid, descriptor, stream_);
  const auto end = static_cast<std::int64_t>(stream_.tellg());
  if (end != entry.end)
    refuse(fmt::format("grid \"{}\" whose voxels end at byte {}, where the file says {}",
                       one_line(entry.name), end, entry.end));
  return grid;
}

openvdb::GridBase::Ptr VdbArchive::read(const Entry& entry) {
  return watched([&] {
    auto grid = read_whole(entry);
    if (entry.parent.empty()) return grid;
    // Two grids, one tree.
    const auto parent = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& other) {
      return other.unique_name == entry.parent;
    });
    if (parent == entries_.end() || !parent->parent.empty() || parent->type != entry.type)
      refuse(fmt::format("grid \"{}\" that shares the tree of \"{}\", which is none",
                         one_line(entry.name), one_line(entry.parent)));
    grid->setTree(read_whole(*parent)->baseTreePtr());
    return grid;
  });
}

}  // namespace lamella
