#include "compare/files/growing_npz.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compare/files/output_folder.h"
#include "compare/files/zip_entries.h"

namespace lamella {

GrowingNpz::GrowingNpz(std::filesystem::path path, std::vector<Column> columns,
                       std::uint64_t zip_limit)
    : path_(std::move(path)), columns_(std::move(columns)), zip_limit_(zip_limit) {
  for (std::size_t k = 0; k < columns_.size(); ++k) growing_.push_back({NamelessFile(path_)});
}

void GrowingNpz::append(std::size_t column, std::string_view rows, std::uint32_t crc) {
  Growing& to = growing_[column];
  to.file.append(rows);
  to.crc = checksum_of_both(to.crc, crc, rows.size());
}

std::uint64_t GrowingNpz::finish(const std::vector<Array>& arrays) {
  ZipEntries zip(zip_limit_);
  StreamedFile out(path_);
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const Column& column = columns_[k];
    Growing& from = growing_[k];
    const std::uint64_t rows = from.file.size() / column.row_bytes;
    const std::string header = npy_header(
        column.type, fmt::format("({},{}{})", rows, column.row.empty() ? "" : " ", column.row));
    out.write(zip.begin(column.name + ".npy",
                        checksum_of_both(checksum(header), from.crc, from.file.size()),
                        header.size() + from.file.size()));
    out.write(header);
    out.append(from.file);
    from.file.close();  // its room on the disk is free
  }
  for (const Array& array : arrays) {
    out.write(zip.begin(array.name + ".npy", checksum(array.npy), array.npy.size()));
    out.write(array.npy);
  }
  out.write(zip.end());
  return out.finish();
}

}  // namespace lamella
