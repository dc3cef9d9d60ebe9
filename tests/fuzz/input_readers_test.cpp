#include "tests/fuzz/input_readers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "compare/files/picture_file.h"

namespace lamella {
namespace {

// Numbers that sizes go wrong at.
constexpr std::uint64_t kOdd[] = {0,          1,          0x7f,       0xff,
                                  0x7fff,     0xffff,     0x7fffffff, 0xffffffff,
                                  1ull << 32, 1ull << 40, 1ull << 63, ~0ull};

std::string changed(std::string bytes, std::mt19937_64& draw) {
  const auto at = [&] { return bytes.empty() ? 0 : draw() % bytes.size(); };
  for (std::uint64_t n = 1 + draw() % 4; n > 0; --n) switch (draw() % 6) {
      case 0:
        if (!bytes.empty()) bytes[at()] = static_cast<char>(draw());
        break;
      case 1:
        bytes.insert(at(), 1 + draw() % 8, static_cast<char>(draw()));
        break;
      case 2:
        bytes.erase(at(), 1 + draw() % 16);
        break;
      case 3:
        bytes.resize(at());
        break;
      case 4: {
        const std::size_t width = std::size_t{1} << draw() % 4;
        const std::uint64_t value = kOdd[draw() % std::size(kOdd)];
        if (bytes.size() >= width)
          bytes.replace(draw() % (bytes.size() - width + 1), width,
                        reinterpret_cast<const char*>(&value), width);
        break;
      }
      default:
        bytes.insert(at(), bytes.substr(at(), draw() % 32));
    }
  return bytes;
}

class Input : public testing::TestWithParam<InputReader> {};

TEST_P(Input, ReadsAnythingOrSaysWhyNot) {
  const InputReader& reader = GetParam();
  const std::vector<std::string> seeds = reader.seeds();
  std::mt19937_64 draw(1);
  for (const std::string& seed : seeds) EXPECT_FALSE(seed.empty());
  EXPECT_FALSE(reader.read(""));
  int taken = 0;
  for (int k = 0; k < reader.changes; ++k)
    taken += reader.read(changed(seeds[draw() % seeds.size()], draw));
  EXPECT_LT(taken, reader.changes);
  RecordProperty("executions", reader.changes);
}

TEST(Inputs, WholeOnesAreTaken) {
  for (const InputReader& reader : input_readers()) {
    // MERL's and a tensor file without a BSDF are beginnings alone.
    if (reader.name == "merl") continue;
    if ((reader.name == "png" || reader.name == "jpeg") && !has_png_and_jpeg()) continue;
    const std::vector<std::string> seeds = reader.seeds();
    EXPECT_TRUE(std::any_of(seeds.begin(), seeds.end(), reader.read)) << reader.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Input, testing::ValuesIn(input_readers()),
                         [](const auto& reader) { return reader.param.name; });

}  // namespace
}  // namespace lamella
