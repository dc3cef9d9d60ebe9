#include "compare/files/zip_entries.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace lamella {
namespace {

// A reader written from the format's description (APPNOTE 4.3), which takes an archive by its
// directory alone. Throws std::out_of_range where a place lies beyond the archive.
class Reader {
 public:
  explicit Reader(std::string bytes) : bytes_(std::move(bytes)) {
    const std::size_t end = bytes_.rfind("PK\5\6");
    std::uint64_t count = at(end + 10, 2), place = at(end + 16, 4);
    if (end >= 20 && bytes_.substr(end - 20, 4) == "PK\6\7") {
      wide_end = true;
      const std::uint64_t record = at(end - 20 + 8, 8);
      EXPECT_EQ(bytes_.substr(record, 4), "PK\6\6");
      count = at(record + 32, 8);
      place = at(record + 48, 8);
    }
    for (; count > 0; --count) {
      EXPECT_EQ(bytes_.substr(place, 4), "PK\1\2");
      const std::uint64_t name = at(place + 28, 2), extra = at(place + 30, 2);
      std::uint64_t size = at(place + 24, 4), from = at(place + 42, 4),
                    more = place + 46 + name + 4;
      if (size == 0xFFFFFFFF) {
        size = at(more, 8);
        more += 16;
      }
      if (from == 0xFFFFFFFF) from = at(more, 8);
      EXPECT_EQ(bytes_.substr(from, 4), "PK\3\4");
      const std::uint64_t start = from + 30 + at(from + 26, 2) + at(from + 28, 2);
      const std::string content = bytes_.substr(start, size);
      EXPECT_EQ(at(place + 16, 4), checksum(content));
      entries[bytes_.substr(place + 46, name)] = content;
      place += 46 + name + extra;
    }
  }

  std::map<std::string, std::string> entries;
  bool wide_end = false;

 private:
  [[nodiscard]] std::uint64_t at(std::uint64_t from, int count) const {
    std::uint64_t value = 0;
    for (int k = count - 1; k >= 0; --k)
      value = value << 8 | static_cast<unsigned char>(bytes_.at(from + k));
    return value;
  }
  std::string bytes_;
};

std::string archive_of(const std::map<std::string, std::string>& entries, std::uint64_t limit) {
  ZipEntries zip(limit);
  std::string bytes;
  for (const auto& [name, content] : entries) {
    bytes += zip.begin(name, checksum(content), content.size());
    bytes += content;
  }
  return bytes + zip.end();
}

TEST(ZipEntries, AreReadBackWithFieldsOf32And64Bits) {
  const std::map<std::string, std::string> entries{
      {"a.npy", std::string(100, 'a')}, {"b.npy", ""}, {"c.npy", std::string(1000, 'c')}};
  // None, sizes, places, all of them beyond the limit.
  for (const std::uint64_t limit : {ZipEntries::kLimit, std::uint64_t{1100}, std::uint64_t{500},
                                    std::uint64_t{150}, std::uint64_t{1}}) {
    const Reader reader(archive_of(entries, limit));
    EXPECT_EQ(reader.entries, entries) << limit;
    EXPECT_EQ(reader.wide_end, limit != ZipEntries::kLimit) << limit;
  }
}

TEST(ZipEntries, HaveTheChecksumOfTheStandard) {
  EXPECT_EQ(checksum("123456789"), 0xCBF43926u);  // the check value of CRC-32/ISO-HDLC
  const std::string text = "one stretch after the other";
  EXPECT_EQ(
      checksum_of_both(checksum(text.substr(0, 10)), checksum(text.substr(10)), text.size() - 10),
      checksum(text));
}

TEST(NumpyHeaders, AreMultiplesOf64Bytes) {
  for (const std::string shape : {"()", "(3,)", "(123456789012, 3)"}) {
    const std::string header = npy_header("<f4", shape);
    EXPECT_EQ(header.size() % 64, 0u);
    EXPECT_EQ(header.back(), '\n');
    EXPECT_EQ(static_cast<unsigned char>(header[8]) + 256 * static_cast<unsigned char>(header[9]),
              static_cast<int>(header.size()) - 10);
  }
}

}  // namespace
}  // namespace lamella
