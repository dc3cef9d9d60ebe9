#include "compare/files/exr_file.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr float kInfiniteFloat = std::numeric_limits<float>::infinity();

ExrImage example() {
  ExrImage image{.width = 3, .height = 2};
  for (const std::string channel : {"R", "G", "B"}) {
    const float c = channel == "R" ? 1.f : channel == "G" ? 10.f : 100.f;
    image.channels.push_back({channel_name(0, "reflect", "all", "", channel),
                              {c, -2 * c, 3 * c, 1e-38f * c, 3e38f / c, 0}});
  }
  image.channels.push_back({channel_name(0, "transmit", "order4plus", "difference", "R"),
                            {1.f / 3, 2.f / 3, 0.1f, 7, 8, 9}});
  image.attributes = {{"stack", "[[layer]]\nmedium = \"sggx\"\n"},
                      {"lamella.seed", "1"},
                      {"a name of more than thirty-one characters", "theta \u00b0"},
                      {"empty", ""}};
  return image;
}

std::vector<std::string> names(const ExrImage& image) {
  std::vector<std::string> result;
  for (const auto& channel : image.channels) result.push_back(channel.first);
  return result;
}

TEST(ExrFile, ComesBackWithEqualValuesAndAttributes) {
  const TemporaryFolder folder;
  const ExrImage image = example();
  write_exr(folder / "a.exr", image);
  const ExrImage back = read_exr(folder / "a.exr");
  EXPECT_EQ(back.width, 3);
  EXPECT_EQ(back.height, 2);
  EXPECT_EQ(back.attributes, image.attributes);
  ASSERT_EQ(back.channels.size(), image.channels.size());
  for (const auto& channel : image.channels)
    EXPECT_THAT(back.channels, testing::Contains(channel)) << channel.first;
}

TEST(ExrFile, PutsPlainChannelsBeforeTheLayers) {
  const TemporaryFolder folder;
  ExrImage image = example();
  add_plain_channels(image);
  add_plain_channels(image);
  write_exr(folder / "a.exr", image);
  const ExrImage back = read_exr(folder / "a.exr");
  EXPECT_THAT(names(back),
              ElementsAre("B", "G", "R", "wi0.reflect.all.B", "wi0.reflect.all.G",
                          "wi0.reflect.all.R", "wi0.transmit.order4plus.difference.R"));
  EXPECT_EQ(back.channels[2].second, image.channels[0].second);
}

TEST(ExrFile, GetsAPlainYWhenGreyAndNoneWithoutTheFirstDirection) {
  ExrImage grey{.width = 1, .height = 1};
  grey.channels = {{"wi0.reflect.all.Y", {2}}, {"wi1.reflect.all.Y", {3}}};
  add_plain_channels(grey);
  EXPECT_THAT(names(grey), ElementsAre("wi0.reflect.all.Y", "wi1.reflect.all.Y", "Y"));
  EXPECT_EQ(grey.channels.back().second, std::vector<float>{2});
  ExrImage other{.width = 1, .height = 1};
  other.channels = {{"wi0.transmit.all.Y", {2}}};
  add_plain_channels(other);
  EXPECT_EQ(other.channels.size(), 1u);
}

TEST(ExrFile, OfEqualImagesIsEqualByteForByteWhateverItsNameAndOrder) {
  const TemporaryFolder folder;
  ExrImage image = example();
  write_exr(folder / "a.exr", image);
  std::reverse(image.channels.begin(), image.channels.end());
  std::filesystem::create_directory(folder / "sub");
  write_exr(folder / "sub/other name.exr", image);
  const std::string bytes = bytes_of(folder / "a.exr");
  EXPECT_EQ(bytes, bytes_of(folder / "sub/other name.exr"));
  EXPECT_EQ(bytes.find(folder.path().string()), std::string::npos);
}

TEST(ExrFile, IsASinglePartScanLineFileWithZip) {
  const TemporaryFolder folder;
  write_exr(folder / "a.exr", example());
  const std::string bytes = bytes_of(folder / "a.exr");
  ASSERT_GT(bytes.size(), 8u);
  EXPECT_EQ(bytes.substr(0, 4), "\x76\x2f\x31\x01");
  // Version 2; of the flags only "long names" (bit 10) may be set: neither tiled, deep nor multi.
  EXPECT_EQ(bytes[4], 2);
  EXPECT_EQ(bytes[5] & ~0x04, 0);
  const std::string name("compression\0compression\0\x01\0\0\0", 28);
  const std::size_t at = bytes.find(name);
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(bytes[at + name.size()], 3) << "3 is ZIP, blocks of 16 lines";
}

TEST(ExrFile, RefusesValuesThatAreNotFinite) {
  const TemporaryFolder folder;
  for (const float bad :
       {kInfiniteFloat, -kInfiniteFloat, std::numeric_limits<float>::quiet_NaN()}) {
    ExrImage image = example();
    image.channels[1].second[4] = bad;
    const std::string message =
        message_of<OutputError>([&] { write_exr(folder / "a.exr", image); });
    EXPECT_THAT(message, HasSubstr((folder / "a.exr").string()));
    EXPECT_THAT(message, HasSubstr("wi0.reflect.all.G"));
    EXPECT_THAT(message, HasSubstr("x = 1, y = 1"));
  }
  EXPECT_EQ(folder.entries(), 0);
}

TEST(ExrFile, RefusesImagesThatDoNotFitTogether) {
  const TemporaryFolder folder;
  const auto refusal = [&](const ExrImage& image) {
    return message_of<OutputError>([&] { write_exr(folder / "a.exr", image); });
  };
  ExrImage image = example();
  image.channels[0].second.pop_back();
  EXPECT_THAT(refusal(image), HasSubstr("5 values instead of 6"));
  image = example();
  image.channels[1].first = image.channels[0].first;
  EXPECT_THAT(refusal(image), HasSubstr("two channels are named wi0.reflect.all.R"));
  image = example();
  image.channels[1].first = "";
  EXPECT_THAT(refusal(image), HasSubstr("without a name"));
  image = example();
  image.attributes["compression"] = "none";
  EXPECT_THAT(refusal(image), HasSubstr("compression"));
  image = example();
  image.attributes["type"] = "deepscanline";
  EXPECT_THAT(refusal(image), HasSubstr("type"));
  EXPECT_THAT(refusal({.width = 2, .height = 2}), HasSubstr("without channels"));
  EXPECT_THAT(refusal({}), HasSubstr("0 x 0"));
  EXPECT_EQ(folder.entries(), 0);
}

TEST(ExrFile, InAnUnwritablePlaceIsAnErrorThatNamesIt) {
  const TemporaryFolder folder;
  const std::string message =
      message_of<OutputError>([&] { write_exr(folder / "none/a.exr", example()); });
  EXPECT_THAT(message, HasSubstr((folder / "none/a.exr").string()));
  EXPECT_THAT(message, HasSubstr("No such file or directory"));
}

TEST(ExrFile, ThatIsMissingCutOrNoneAtAllIsAnErrorThatNamesIt) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& name) {
    const std::string message = message_of<OutputError>([&] { (void)read_exr(folder / name); });
    EXPECT_THAT(message, HasSubstr((folder / name).string()));
    return message;
  };
  EXPECT_THAT(refusal("missing.exr"), HasSubstr("No such file"));
  write_file(folder / "text.exr", "not a picture");
  (void)refusal("text.exr");
  write_exr(folder / "a.exr", example());
  const std::string bytes = bytes_of(folder / "a.exr");
  for (const std::size_t size : {0, 3, 100}) {
    write_file(folder / "cut.exr", bytes.substr(0, size));
    (void)refusal("cut.exr");
  }
  write_file(folder / "cut.exr", bytes.substr(0, bytes.size() - 10));
  (void)refusal("cut.exr");
}

TEST(ExrValues, AreTheNearestFloats) {
  EXPECT_THAT(exr_values(std::vector<double>{0.1, -3e38, 1e-60}), ElementsAre(0.1f, -3e38f, 0.f));
}

TEST(ExrValues, RefuseWhatFloatsCannotHold) {
  for (const double bad : {1e39, -1e39, static_cast<double>(kInfiniteFloat), std::nan("")})
    EXPECT_THAT(message_of<OutputError>([&] {
                  (void)exr_values(std::vector<double>{1, bad});
                }),
                HasSubstr("index 1"));
}

TEST(ChannelName, HasThePartOnlyWhereThereIsOne) {
  EXPECT_EQ(channel_name(0, "reflect", "all", "", "R"), "wi0.reflect.all.R");
  EXPECT_EQ(channel_name(0, "reflect", "order1", "se", "R"), "wi0.reflect.order1.se.R");
  EXPECT_EQ(channel_name(12, "transmit", "order4plus", "z", "Y"), "wi12.transmit.order4plus.z.Y");
}

}  // namespace
}  // namespace lamella
