#include "compare/files/exr_parts.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gmock/gmock.h>

#include <cstdint>
#include <fstream>
#include <vector>

#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kWidth = 37, kHeight = 21;

void write_tiled(const std::filesystem::path& path, Imf::LevelMode mode) {
  Imf::Header header(kWidth, kHeight);
  header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  header.setTileDescription(Imf::TileDescription(16, 8, mode));
  std::vector<float> values(kWidth * kHeight);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = static_cast<float>(k);
  Imf::TiledOutputFile file(path.c_str(), header);
  for (int level = 0; level < file.numLevels(); ++level) {
    Imf::FrameBuffer frame;
    const auto stride = sizeof(float) * static_cast<std::size_t>(file.levelWidth(level));
    frame.insert(
        "Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float), stride));
    file.setFrameBuffer(frame);
    file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
  }
}

TEST(ExrParts, ReadTilesAsThePictureThatTheyCover) {
  const TemporaryFolder folder;
  for (const auto mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS}) {
    write_tiled(folder / "tiled.exr", mode);
    const auto parts = read_exr_parts(folder / "tiled.exr");
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].kind, "tiledimage");
    const ExrImage image = read_exr_part(folder / "tiled.exr", 0, {"Y"});
    ASSERT_EQ(image.width, kWidth);
    ASSERT_EQ(image.height, kHeight);
    for (std::size_t k = 0; k < image.channels[0].second.size(); ++k)
      ASSERT_EQ(image.channels[0].second[k], static_cast<float>(k));
  }
}

// OpenEXR asks for the memory of an attribute before it reads it.
TEST(ExrParts, RefuseAttributesOfMoreBytesThanTheFileHas) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.exr";
  const auto write = [&](std::uint32_t size) {
    std::string bytes("\x76\x2f\x31\x01\x02\x00\x00\x00what\0kind\0", 18);
    for (int k = 0; k < 4; ++k) bytes += static_cast<char>(size >> 8 * k & 255);
    std::ofstream(path, std::ios::binary) << bytes << "abcd";
  };
  write(0x69696969);
  try {
    (void)read_exr_parts(path);
    FAIL();
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("an attribute of 1768515945 bytes, where the file has 4"));
  }
  // A type of 4 bytes that says it has 3.
  std::ofstream(path, std::ios::binary)
      << std::string("\x76\x2f\x31\x01\x02\x00\x00\x00what\0int\0\x03\0\0\0abcd", 25);
  try {
    (void)read_exr_parts(path);
    FAIL();
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the type int with 3 bytes, where its content has 4"));
  }
  write(4);  // what else is wrong with it is the library's to say
  EXPECT_THROW((void)read_exr_parts(path), OutputError);
}

TEST(ExrParts, RefuseSubsampledColours) {
  const TemporaryFolder folder;
  {
    std::vector<Imf::Rgba> pixels(64 * 32, Imf::Rgba(0.5f, 0.25f, 1.f));
    Imf::RgbaOutputFile file((folder / "yc.exr").c_str(), 64, 32, Imf::WRITE_YC);
    file.setFrameBuffer(pixels.data(), 1, 64);
    file.writePixels(32);
  }
  const auto parts = read_exr_parts(folder / "yc.exr");
  EXPECT_TRUE(find_colors(parts).empty());
  EXPECT_EQ(channels_text(parts), "BY, RY, Y");
  EXPECT_THAT(message_of<OutputError>([&] { (void)read_exr_part(folder / "yc.exr", 0, {"RY"}); }),
              HasSubstr("channel RY is subsampled"));
}

TEST(ExrParts, TellDeepPartsAndRefuseToReadThem) {
  const TemporaryFolder folder;
  {
    Imf::Header header(2, 1);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    for (const char* name : {"R", "G", "B"})
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    unsigned int counts[2] = {1, 1};
    float values[2] = {1, 2};
    float* pointers[2] = {&values[0], &values[1]};
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts),
                                            sizeof(unsigned int), 2 * sizeof(unsigned int)));
    for (const char* name : {"R", "G", "B"})
      frame.insert(name, Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers),
                                        sizeof(float*), 2 * sizeof(float*), sizeof(float)));
    Imf::DeepScanLineOutputFile file((folder / "deep.exr").c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(1);
  }
  const auto parts = read_exr_parts(folder / "deep.exr");
  EXPECT_EQ(parts[0].kind, "deepscanline");
  EXPECT_TRUE(find_colors(parts).empty());
  EXPECT_THAT(channels_text(parts), HasSubstr("(deep)"));
  EXPECT_THAT(message_of<OutputError>([&] { (void)read_exr_part(folder / "deep.exr", 0, {"R"}); }),
              HasSubstr("is deep"));
}

ExrPart part_with(std::initializer_list<const char*> names, std::string name = "") {
  ExrPart part;
  part.name = std::move(name);
  part.kind = "scanlineimage";
  for (const char* channel : names) part.channels.push_back({channel, "half"});
  return part;
}

std::vector<std::string> taken(const std::vector<ExrPart>& parts) {
  const auto found = find_colors(parts);
  if (found.empty()) return {};
  std::vector<std::string> words = found.front().channels;
  words.push_back(std::to_string(found.front().part));
  return words;
}

TEST(FindColors, TakesPlainChannelsBeforeLayersAndColourBeforeLuminance) {
  EXPECT_THAT(taken({part_with({"a.B", "a.G", "a.R", "B", "G", "R"})}),
              ElementsAre("R", "G", "B", "0"));
  EXPECT_THAT(taken({part_with({"a.B", "a.G", "a.R"}), part_with({"b", "g", "r"})}),
              ElementsAre("r", "g", "b", "1"));
  EXPECT_THAT(taken({part_with({"Y"}), part_with({"x.B", "x.G", "x.R"})}),
              ElementsAre("x.R", "x.G", "x.B", "1"));
  EXPECT_THAT(taken({part_with({"V.AO.B", "V.AO.G", "V.AO.R", "V.Combined.A", "V.Combined.B",
                                "V.Combined.G", "V.Combined.R"})}),
              ElementsAre("V.Combined.R", "V.Combined.G", "V.Combined.B", "0"));
  EXPECT_THAT(taken({part_with({"l.Y"})}), ElementsAre("l.Y", "0"));
}

TEST(FindColors, DoesNotTakeNormalsOrHalfAPicture) {
  EXPECT_TRUE(find_colors({part_with({"N.X", "N.Y", "N.Z", "R", "G"})}).empty());
  EXPECT_TRUE(find_colors({part_with({"X", "Y", "Z"})}).empty());
  EXPECT_TRUE(find_colors({part_with({"a.R", "a.G", "b.B"})}).empty());
}

TEST(ChannelsText, NamesPartsAndIsShort) {
  EXPECT_EQ(channels_text({part_with({"R", "Z"}, "left"), part_with({"G"})}),
            "part 0 \"left\": R, Z; part 1: G");
  ExrPart many;
  for (int k = 0; k < 100; ++k) many.channels.push_back({"c" + std::to_string(k), "half"});
  EXPECT_THAT(channels_text({many}), HasSubstr("and 76 more"));
  EXPECT_EQ(channels_text({ExrPart{}}), "none");
}

}  // namespace
}  // namespace lamella
