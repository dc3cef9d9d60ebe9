#include "phase/stack/text_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "phase/parameters/one_line.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

std::string refusal_of(const std::string& path, std::size_t most = 1 << 20) {
  try {
    (void)read_text_file(path, most, 0.05);
  } catch (const TextFileError& error) {
    return error.what();
  }
  return "no refusal";
}

TEST(TextFile, IsReadWholeOrRefusedInBoundedTimeAndMemory) {
  std::string folder = (fs::temp_directory_path() / "lamella-text-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const std::string text(300000, 'x');
  std::ofstream(folder + "/text") << text;
  EXPECT_EQ(read_text_file(folder + "/text", 1 << 20), text);
  EXPECT_EQ(refusal_of(folder + "/text", 100000), "holds more than 0 MiB");
  EXPECT_EQ(refusal_of(folder), "is a directory");
  EXPECT_EQ(refusal_of(folder + "/none"), "No such file or directory");
  EXPECT_EQ(refusal_of("/dev/zero"), "is a device");
  ASSERT_EQ(mkfifo((folder + "/pipe").c_str(), 0600), 0);
  EXPECT_EQ(refusal_of(folder + "/pipe"), "is a pipe that nobody writes to within 0.05 s");
  std::thread writer([&] { std::ofstream(folder + "/pipe") << text; });
  EXPECT_EQ(read_text_file(folder + "/pipe", 1 << 20), text);
  writer.join();
  fs::remove_all(folder);
}

TEST(OneLine, JoinsLinesAndCutsWhatIsLong) {
  EXPECT_EQ(one_line("a\n  b\tc\r\n"), "a b c");
  EXPECT_EQ(one_line("  \"0  45\" \n"), "\"0  45\"");
  EXPECT_LE(one_line("x" + std::string(1000, ' ') + "x", 10).size(), 10u);
  EXPECT_EQ(one_line("\x1b[1mred\x01"), "?[1mred?");
  EXPECT_EQ(one_line("gr\xc3\xbc\xc3\x9f"), "gr\xc3\xbc\xc3\x9f");
  EXPECT_EQ(one_line("\xff\xfe x"), "?? x");
  EXPECT_EQ(one_line(std::string(1000, 'x'), 10), "xxxxxxx...");
  EXPECT_EQ(one_line(std::string(20, '\xc3') + "\xbc", 10), "???????...");
  EXPECT_EQ(one_line("xxxxxx\xc3\xbcxxxx", 10), "xxxxxx...");
}

}  // namespace
}  // namespace lamella
