#include "compare/files/folder_lock.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <optional>

#include "compare/files/output_folder.h"
#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

using testing::HasSubstr;

TEST(FolderLock, TellsASecondRunWhoWorksThere) {
  const TemporaryFolder folder;
  const FolderLock first(folder.path());
  const std::string message =
      message_of<FolderInUse>([&] { const FolderLock second(folder.path()); });
  EXPECT_THAT(message, HasSubstr(folder.path().string()));
  EXPECT_THAT(message, HasSubstr("another run, pid " + std::to_string(::getpid()) + " on host "));
}

TEST(FolderLock, IsGivenBackAndLeavesNothing) {
  const TemporaryFolder folder;
  { const FolderLock first(folder.path()); }
  EXPECT_EQ(folder.entries(), 0);
  const FolderLock second(folder.path());
}

TEST(FolderLock, OfAKilledRunStopsNobody) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const FolderLock lock(folder.path());
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_EQ(folder.entries(), 1);  // its file is still there
  std::optional<FolderLock> lock;
  EXPECT_NO_THROW(lock.emplace(folder.path()));
  lock.reset();
  EXPECT_EQ(folder.entries(), 0);
}

TEST(FolderLock, OfAFolderThatIsNotThereIsRefusedByName) {
  const TemporaryFolder folder;
  EXPECT_THAT(message_of<OutputError>([&] { const FolderLock lock(folder / "absent"); }),
              HasSubstr((folder / "absent").string()));
}

}  // namespace
}  // namespace lamella
