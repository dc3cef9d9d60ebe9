#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lamella {

/// Bytes of zip archives without compression, with 64-bit fields where sizes or places ask for
/// them (PKWARE's APPNOTE 6.3.9, 4.3). All times are 1980-01-01, so that equal content gives equal
/// archives.
class ZipEntries {
 public:
  /// From this size or place on fields have 64 bits.
  static constexpr std::uint64_t kLimit = 0xFFFFFFFF;
  /// limit: a lower one, for tests.
  explicit ZipEntries(std::uint64_t limit = kLimit) : limit_(limit) {}

  /// The bytes in front of an entry's own, which follow them at once. crc: that of its bytes
  /// (CRC-32 of ISO 3309).
  [[nodiscard]] std::string begin(const std::string& name, std::uint32_t crc, std::uint64_t size);
  /// The bytes at the archive's end.
  [[nodiscard]] std::string end();

 private:
  std::uint64_t limit_;
  std::string directory_;
  std::uint64_t at_ = 0, count_ = 0;
};

/// CRC-32 of bytes, and of two stretches of bytes one after the other.
[[nodiscard]] std::uint32_t checksum(std::string_view bytes);
[[nodiscard]] std::uint32_t checksum_of_both(std::uint32_t first, std::uint32_t second,
                                             std::uint64_t second_size);

/// The bytes in front of an array in NumPy's format 1.0 (NEP 1). type: "<f8"; shape: as Python
/// writes a tuple, "(3, 4)".
[[nodiscard]] std::string npy_header(const std::string& type, const std::string& shape);
/// A text as NumPy's array of no axes, four bytes a letter; other letters than ASCII become "?".
[[nodiscard]] std::string npy_text(const std::string& text);

}  // namespace lamella
