#include "compare/report/wrapped_text.h"

#include <gtest/gtest.h>

#include <sstream>

namespace lamella {
namespace {

TEST(WrappedText, HasLinesOfAtMostTheTerminalsWidthAndLosesNoWord) {
  std::string text;
  for (int k = 0; k < 100; ++k) text += "word" + std::to_string(k) + " ";
  const std::string out = wrapped("  name  ", text);
  std::istringstream lines(out), words(out);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), kTerminalWidth);
    EXPECT_GT(line.size(), 8U);
  }
  std::string word;
  words >> word;
  EXPECT_EQ(word, "name");
  for (int k = 0; k < 100; ++k) {
    words >> word;
    EXPECT_EQ(word, "word" + std::to_string(k));
  }
}

TEST(WrappedText, CountsLettersAndKeepsLongWordsWhole) {
  const std::string greek(2 * kTerminalWidth, '\xb1');  // continuation bytes
  EXPECT_EQ(wrapped("", "\xc2" + greek), "\xc2" + greek + "\n");
  const std::string word(kTerminalWidth + 20, 'w');
  EXPECT_EQ(wrapped("a: ", word + " b", 2), "a: " + word + "\n  b\n");
}

}  // namespace
}  // namespace lamella
