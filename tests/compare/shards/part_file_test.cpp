#include "compare/shards/part_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "compare/files/content_hash.h"
#include "compare/files/output_folder.h"
#include "compare/request/errors.h"
#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

const Part kPart{{{"command", "simulate"}, {"n", 1}}, {{0, "first"}, {3, ""}, {kInputPiece, "in"}}};

void put(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// With the sum that belongs to the bytes: whoever makes a file by hand can add it, too.
std::string summed(const std::string& bytes) { return bytes + content_hash(bytes) + "\n"; }

std::string number(std::uint64_t n) { return {reinterpret_cast<const char*>(&n), sizeof n}; }

std::string file_of(std::uint64_t header_size, std::uint64_t count, const std::string& rest) {
  return summed("lamella part 1\n" + number(header_size) + number(count) + rest);
}

TEST(PartFile, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  write_part(folder / "a.part", kPart);
  EXPECT_EQ(folder.entries(), 1);
  const PartFile file(folder / "a.part");
  EXPECT_EQ(file.header(), kPart.header);
  EXPECT_EQ(file.text("command"), "simulate");
  EXPECT_EQ(file.piece(0, 5), "first");
  EXPECT_TRUE(file.has(3));
  EXPECT_FALSE(file.has(1));
  EXPECT_EQ(file.all(7).pieces, kPart.pieces);
}

TEST(PartFile, TakesPiecesFromTheFileThatItReplaces) {
  const TemporaryFolder folder;
  write_part(folder / "a.part", kPart);
  StoredPieces pieces = pieces_of(std::make_shared<const PartFile>(folder / "a.part"));
  pieces.insert_or_assign(3, StoredPiece("third"));
  write_part(folder / "a.part", kPart.header, pieces);
  const PartFile file(folder / "a.part");
  EXPECT_EQ(file.piece(0, 5), "first");
  EXPECT_EQ(file.piece(3, 5), "third");
  EXPECT_EQ(loaded(pieces_of(std::make_shared<const PartFile>(folder / "a.part"))),
            file.all(100).pieces);
  // The same bytes as from memory.
  write_part(folder / "b.part", Part{kPart.header, file.all(100).pieces});
  EXPECT_EQ(content_hash_of_file(folder / "a.part"), content_hash_of_file(folder / "b.part"));
}

TEST(PartFile, RefusesWhatIsNotThere) {
  const TemporaryFolder folder;
  write_part(folder / "a.part", kPart);
  const PartFile file(folder / "a.part");
  EXPECT_THAT(message_of<UsageError>([&] { (void)file.piece(1, 9); }), HasSubstr("no piece 1"));
  EXPECT_THAT(message_of<UsageError>([&] { (void)file.piece(0, 4); }), HasSubstr("5 bytes"));
  EXPECT_THAT(message_of<UsageError>([&] { (void)file.all(6); }), HasSubstr("bytes"));
  EXPECT_THAT(message_of<UsageError>([&] { (void)file.text("n"); }), HasSubstr("no \"n\""));
  EXPECT_THROW(PartFile(folder / "none.part"), OutputError);
  EXPECT_THROW(PartFile(folder.path()), OutputError);
  EXPECT_THROW(PartFile("/dev/zero"), OutputError);
}

TEST(PartFile, RefusesEveryCutAndEveryFlippedBit) {
  const TemporaryFolder folder;
  write_part(folder / "a.part", kPart);
  const std::string whole = bytes_of(folder / "a.part");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    put(folder / "b.part", whole.substr(0, size));
    EXPECT_THAT(message_of<UsageError>([&] { PartFile(folder / "b.part"); }), HasSubstr("b.part"))
        << size;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string other = whole;
    other[at] = static_cast<char>(other[at] ^ (1 << at % 8));
    put(folder / "b.part", other);
    EXPECT_THAT(message_of<UsageError>([&] { PartFile(folder / "b.part"); }),
                HasSubstr("allowed: "))
        << at;
  }
  put(folder / "b.part", whole + "x");
  EXPECT_THROW(PartFile(folder / "b.part"), UsageError);
}

TEST(PartFile, RefusesSizesThatAreNoneBeforeItMakesRoom) {
  const TemporaryFolder folder;
  const std::uint64_t huge = std::uint64_t{1} << 62;
  const std::string deep(100000, '[');
  const std::vector<std::string> files{
      file_of(huge, 0, ""),
      file_of(0, huge, ""),
      file_of(2, 1 << 21, "{}"),
      file_of(2, 1, "{}" + number(0) + number(huge)),
      file_of(2, 1, "{}" + number(0) + number(~std::uint64_t{0})),
      file_of(2, 2, "{}" + number(0) + number(0) + number(0) + number(0)),
      file_of(2, 1, "{}" + number(0) + number(0) + "more"),
      file_of(2, 0, "[]"),
      file_of(2, 0, "{x"),
      file_of(0, 0, ""),
      file_of(deep.size(), 0, deep),
      file_of(deep.size() + 5, 0, "{\"a\":" + deep),
  };
  for (const std::string& bytes : files) {
    put(folder / "a.part", bytes);
    EXPECT_THAT(message_of<UsageError>([&] { PartFile(folder / "a.part"); }),
                HasSubstr("allowed: "))
        << bytes.substr(0, 60);
  }
}

}  // namespace
}  // namespace lamella
