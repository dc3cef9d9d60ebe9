#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "compare/files/streamed_file.h"

namespace lamella {

/// An archive of NumPy arrays (.npz) whose rows come piece by piece: memory does not grow with
/// them. Until `finish` each array is in memory up to 64 MiB, and beyond in a file without a name
/// beside the archive, which the system removes however the process ends; the archive is written
/// whole, synced and renamed then.
class GrowingNpz {
 public:
  struct Column {
    std::string name, type;  ///< "w_i", "<f4"
    std::string row;         ///< the shape of a row as it follows the number of rows: "3", or ""
    std::uint64_t row_bytes;
  };
  /// zip_limit: see ZipEntries. Throws OutputError where nothing can be written.
  GrowingNpz(std::filesystem::path path, std::vector<Column> columns,
             std::uint64_t zip_limit = 0xFFFFFFFF);

  /// Appends rows of a column, and their CRC-32 (checksum of files/zip_entries.h). Throws
  /// OutputError.
  void append(std::size_t column, std::string_view rows, std::uint32_t crc);

  /// Further arrays, whole: name and bytes of a .npy file.
  struct Array {
    std::string name, npy;
  };
  /// Writes the archive. All columns have the same number of rows. Throws OutputError. Returns its
  /// size in bytes.
  std::uint64_t finish(const std::vector<Array>& arrays);

 private:
  struct Growing {
    NamelessFile file;
    std::uint32_t crc = 0;
  };

  std::filesystem::path path_;
  std::vector<Column> columns_;
  std::vector<Growing> growing_;
  std::uint64_t zip_limit_;
};

}  // namespace lamella
