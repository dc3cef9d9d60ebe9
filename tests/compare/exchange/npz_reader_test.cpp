#include "compare/exchange/npz_reader.h"

#include <gtest/gtest.h>

#include <random>

#include "compare/exchange/tensor_container.h"
#include "compare/files/zip_entries.h"

namespace lamella {
namespace {

LobeSet coloured_set() {
  LobeSet set;
  set.directions = {{0, 0, 1}, {0.6, 0, 0.8}};
  set.grid = {.mu_cells = 2, .phi_cells = 4, .folded = true};
  set.channels = 3;
  const std::size_t count = set.directions.size() * 3 * set.grid.cells();
  // Names that sort between a lobe and its errors.
  for (const char* name : {"1", "1+", "all"}) {
    LobeBlock block{"reflect", name, {}, {}};
    for (std::size_t k = 0; k < count; ++k) {
      block.value.push_back(static_cast<double>(k) + 0.25);
      block.standard_error.push_back(1e-3 * static_cast<double>(k));
    }
    set.lobes.push_back(block);
  }
  set.attributes["lamella.stack"] = "[[layer]]";
  return set;
}

TEST(NpzReader, ReadsWhatLobeNpzWrites) {
  const LobeSet set = coloured_set();
  const std::string bytes = lobe_npz(set, {{"points", {2, 1}, {3, 4}}});
  const auto arrays = read_npz(bytes, "a.npz");
  EXPECT_EQ(arrays.at("points").values, (std::vector<double>{3, 4}));
  const LobeSet read = lobes_of_npz(arrays, "a.npz");
  EXPECT_EQ(read.grid, set.grid);
  EXPECT_EQ(read.channels, 3);
  EXPECT_EQ(read.attributes.at("lamella.stack"), "[[layer]]");
  ASSERT_EQ(read.lobes.size(), set.lobes.size());
  for (const LobeBlock& lobe : set.lobes) {
    const LobeBlock* found = read.lobe(lobe.side, lobe.name);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->value, lobe.value);
    EXPECT_EQ(found->standard_error, lobe.standard_error);
  }
}

TEST(NpzReader, RefusesEveryTruncationInOneLine) {
  const std::string bytes = lobe_npz(coloured_set());
  const std::size_t directory = bytes.find("PK\x01\x02");
  for (std::size_t size = 0; size < directory + 4; size += 7) {
    try {
      (void)lobes_of_npz(read_npz(bytes.substr(0, size), "a.npz"), "a.npz");
      ADD_FAILURE() << size;
    } catch (const FormatError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

// A wrong byte of a member is seen by its checksum; of a header, by what it makes of the archive,
// but for fields without a meaning here (versions, times).
TEST(NpzReader, SurvivesRandomChangesWithinTheFileSize) {
  const std::string whole = lobe_npz(coloured_set());
  std::mt19937_64 draw(1);
  int refused = 0;
  for (int k = 0; k < 3000; ++k) {
    std::string bytes = whole;
    for (unsigned n = 0; n <= draw() % 3; ++n)
      bytes[draw() % bytes.size()] = static_cast<char>(draw());
    try {
      (void)lobes_of_npz(read_npz(bytes, "a.npz"), "a.npz");
    } catch (const FormatError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1500);
}

TEST(NpzReader, KnowsTheCheckValueOfItsChecksum) {
  // The check value of CRC-32/ISO-HDLC.
  EXPECT_EQ(checksum("123456789"), 0xCBF43926u);
}

}  // namespace
}  // namespace lamella
