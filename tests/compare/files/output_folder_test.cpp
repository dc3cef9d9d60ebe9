#include "compare/files/output_folder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <thread>
#include <vector>

#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(OutputFolder, IsMadeWithItsParentsAndTakenAsItIsTheNextTime) {
  const TemporaryFolder folder;
  make_output_folder(folder / "a/b");
  write_file(folder / "a/b/kept", "x");
  make_output_folder(folder / "a/b");
  EXPECT_EQ(bytes_of(folder / "a/b/kept"), "x");
}

TEST(OutputFolder, ThatIsAFileIsRefusedByName) {
  const TemporaryFolder folder;
  write_file(folder / "taken", "x");
  const std::string message =
      message_of<OutputError>([&] { make_output_folder(folder / "taken"); });
  EXPECT_THAT(message, HasSubstr((folder / "taken").string()));
  EXPECT_THAT(message, HasSubstr("file"));
}

TEST(OutputFolder, BelowAFileIsRefusedWithTheSystemsReason) {
  const TemporaryFolder folder;
  write_file(folder / "taken", "x");
  const std::string message =
      message_of<OutputError>([&] { make_output_folder(folder / "taken/below"); });
  EXPECT_THAT(message, HasSubstr((folder / "taken/below").string()));
  EXPECT_THAT(message, HasSubstr("Not a directory"));
}

TEST(OutputFolder, WithoutWritePermissionIsRefused) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryFolder folder;
  make_output_folder(folder / "locked");
  fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THAT(message_of<OutputError>([&] { make_output_folder(folder / "locked"); }),
              HasSubstr("Permission denied"));
  EXPECT_THAT(message_of<OutputError>([&] { write_file(folder / "locked/file", "x"); }),
              HasSubstr("Permission denied"));
}

TEST(WriteFile, ReplacesTheWholeFileAndLeavesNothingElse) {
  const TemporaryFolder folder;
  const std::string zeros("a\0b\nlong", 8);
  write_file(folder / "f", zeros);
  EXPECT_EQ(bytes_of(folder / "f"), zeros);
  write_file(folder / "f", "new");
  EXPECT_EQ(bytes_of(folder / "f"), "new");
  EXPECT_EQ(folder.entries(), 1);
}

TEST(WriteFile, TakesTheLongestNameAFileCanHave) {
  const TemporaryFolder folder;
  const std::string name(255, 'n');
  write_file(folder / name, "x");
  EXPECT_EQ(bytes_of(folder / name), "x");
}

TEST(WriteFile, ErrorsNamePathAndReasonAndLeaveNoTemporaryFile) {
  const TemporaryFolder folder;
  const std::string missing =
      message_of<OutputError>([&] { write_file(folder / "none/file", "x"); });
  EXPECT_THAT(missing, HasSubstr((folder / "none/file").string()));
  EXPECT_THAT(missing, HasSubstr("No such file or directory"));
  EXPECT_THAT(message_of<OutputError>([&] { write_file(folder.path(), "x"); }),
              HasSubstr("Is a directory"));
  EXPECT_THAT(message_of<OutputError>([&] { write_file(folder / std::string(256, 'n'), "x"); }),
              HasSubstr("File name too long"));
  EXPECT_EQ(folder.entries(), 0);
}

TEST(WriteFile, FollowsASymbolicLinkInsteadOfReplacingIt) {
  const TemporaryFolder folder;
  write_file(folder / "target", "old");
  fs::create_symlink("target", folder / "link");
  write_file(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(bytes_of(folder / "target"), "new");
}

TEST(WriteFile, WritesToAPipeWithoutReplacingIt) {
  const TemporaryFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_file(pipe, "through");
  char seen[16] = {};
  EXPECT_EQ(::read(reader, seen, sizeof seen), 7);
  ::close(reader);
  EXPECT_STREQ(seen, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(WriteFile, ShowsReadersOnlyWholeFiles) {
  const TemporaryFolder folder;
  const std::string a(100000, 'a'), b(100000, 'b');
  write_file(folder / "f", a);
  std::thread writer([&] {
    for (int i = 0; i < 100; ++i) write_file(folder / "f", i % 2 == 0 ? b : a);
  });
  for (int i = 0; i < 100; ++i) {
    const std::string seen = bytes_of(folder / "f");
    EXPECT_TRUE(seen == a || seen == b) << seen.size();
  }
  writer.join();
  EXPECT_EQ(folder.entries(), 1);
}

}  // namespace
}  // namespace lamella
