#include "compare/files/zip_entries.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace lamella {
namespace {

static_assert(std::endian::native == std::endian::little, "archives are little-endian");

void put(std::string& to, std::uint64_t value, int bytes) {
  for (int k = 0; k < bytes; ++k) to += static_cast<char>(value >> 8 * k & 255);
}

}  // namespace

std::string ZipEntries::begin(const std::string& name, std::uint32_t crc, std::uint64_t size) {
  const bool wide = size >= limit_, far = at_ >= limit_;
  const auto common = [&](bool wide_place) {
    const bool any = wide || wide_place;
    std::string bytes;
    put(bytes, any ? 45 : 20, 2);  // the version that is needed: 4.5 or 2.0
    put(bytes, 0, 2);              // flags
    put(bytes, 0, 2);              // stored
    put(bytes, 0, 2);              // no time
    put(bytes, 0x21, 2);           // 1980-01-01
    put(bytes, crc, 4);
    put(bytes, wide ? kLimit : size, 4);
    put(bytes, wide ? kLimit : size, 4);
    put(bytes, name.size(), 2);
    put(bytes, any ? 4 + (wide ? 16 : 0) + (wide_place ? 8 : 0) : 0, 2);
    return bytes;
  };
  const auto extra = [&](bool wide_place) {
    std::string bytes;
    if (!wide && !wide_place) return bytes;
    put(bytes, 1, 2);
    put(bytes, (wide ? 16 : 0) + (wide_place ? 8 : 0), 2);
    if (wide) put(bytes, size, 8);
    if (wide) put(bytes, size, 8);
    if (wide_place) put(bytes, at_, 8);
    return bytes;
  };
  put(directory_, 0x02014b50, 4);
  put(directory_, wide || far ? 45 : 20, 2);  // made by that version
  directory_ += common(far);
  put(directory_, 0, 2);  // no comment
  put(directory_, 0, 2);  // first disk
  put(directory_, 0, 2);  // no attributes
  put(directory_, 0, 4);
  put(directory_, far ? kLimit : at_, 4);
  directory_ += name + extra(far);
  ++count_;
  std::string bytes;
  put(bytes, 0x04034b50, 4);
  bytes += common(false) + name + extra(false);
  at_ += bytes.size() + size;
  return bytes;
}

std::string ZipEntries::end() {
  std::string bytes = std::exchange(directory_, {});
  const std::uint64_t size = bytes.size();
  if (at_ >= limit_ || size >= limit_) {
    put(bytes, 0x06064b50, 4);
    put(bytes, 44, 8);  // what follows of this record
    put(bytes, 45, 2);
    put(bytes, 45, 2);
    put(bytes, 0, 8);  // disks
    put(bytes, count_, 8);
    put(bytes, count_, 8);
    put(bytes, size, 8);
    put(bytes, at_, 8);
    put(bytes, 0x07064b50, 4);
    put(bytes, 0, 4);
    put(bytes, at_ + size, 8);
    put(bytes, 1, 4);
  }
  put(bytes, 0x06054b50, 4);
  put(bytes, 0, 4);
  put(bytes, count_, 2);
  put(bytes, count_, 2);
  put(bytes, size >= limit_ ? kLimit : size, 4);
  put(bytes, at_ >= limit_ ? kLimit : at_, 4);
  put(bytes, 0, 2);
  return bytes;
}

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

std::uint32_t checksum_of_both(std::uint32_t first, std::uint32_t second,
                               std::uint64_t second_size) {
  return static_cast<std::uint32_t>(
      crc32_combine(first, second, static_cast<z_off_t>(second_size)));
}

std::string npy_header(const std::string& type, const std::string& shape) {
  std::string header =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  put(bytes, header.size(), 2);
  return bytes + header;
}

std::string npy_text(const std::string& text) {
  std::string data;
  for (const char c : text) put(data, static_cast<unsigned char>(c) < 128 ? c : '?', 4);
  if (text.empty()) put(data, 0, 4);
  return npy_header(fmt::format("<U{}", std::max<std::size_t>(text.size(), 1)), "()") + data;
}

}  // namespace lamella
