#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace lamella {

/// Fills OpenVDB's registry of types; to be called once per process, before any other use of
/// OpenVDB.
void initialize_openvdb();

/// A .vdb file grid by grid, read by OpenVDB's own routines from a stream that is watched: a read
/// beyond the end throws, and each grid's end is compared with the file's size before the grid is
/// read, and with the place where reading ended. io::File does neither. Throws GridFileError, and
/// std::bad_alloc. A grid that has been given out, or begun, is never destroyed: the class is for a
/// process that ends after reading, and OpenVDB destroys trees on threads, of which a forked
/// process has but one.
class VdbArchive : private openvdb::io::Archive {
 public:
  /// The file's header of a grid.
  struct Entry {
    std::string name;  ///< without the suffix that makes it unique
    std::string unique_name;
    std::string type;    ///< "Tree_float_5_4_3"
    std::string parent;  ///< unique name of the grid whose tree it shares, or empty
    std::int64_t descriptor = 0, grid = 0, end = 0;  ///< places in the file
  };

  explicit VdbArchive(const std::string& path);

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] const openvdb::MetaMap& metadata() const { return metadata_; }
  [[nodiscard]] openvdb::GridBase::Ptr read(const Entry& entry);

 private:
  template <class F>
  auto watched(const F& f) -> decltype(f());
  void open();
  void list();
  void read_all();
  openvdb::GridBase::Ptr read_whole(const Entry& entry);

  std::ifstream stream_;
  std::int64_t size_ = 0;
  openvdb::MetaMap metadata_;
  openvdb::io::StreamMetadata::Ptr stream_metadata_;
  std::vector<Entry> entries_;
  std::vector<openvdb::GridBase::Ptr> streamed_;  // of a file of io::Stream, as entries_
};

}  // namespace lamella
