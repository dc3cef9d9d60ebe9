#include "phase/stack/mapped_stack.h"

#include <gtest/gtest.h>

#include <array>
#include <map>

#include "phase/stack/stack_file.h"

namespace lamella::testing {
namespace {

constexpr const char* kMapped =
    "[[layer]]\nmedium = 'sggx'\nroughness = { map = 'r.png', scale = [0.1, 0.6] }\n"
    "axis = { map = 'n.exr', encoding = 'normal' }\nalbedo = 'wood.JPG'\nthickness = 1\n"
    "[substrate]\nbsdf = 'eon'\nalbedo = 'ground.exr'\n";

std::string refusal(const std::string& text) {
  try {
    (void)MappedStack(text, "folder/a.toml", "a");
  } catch (const StackFileError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(MappedStack, KnowsItsPicturesAndWhatTheirKeysTake) {
  const MappedStack stack(kMapped, "folder/a.toml", "a");
  ASSERT_EQ(stack.maps().size(), 4U);
  std::map<std::string, const MappedKey*> keys;
  for (const MappedKey& key : stack.maps()) keys[key.path()] = &key;
  EXPECT_EQ(keys.at("layer.0.albedo")->map.file, "wood.JPG");
  EXPECT_EQ(keys.at("layer.0.albedo")->map.folder, "folder");
  EXPECT_EQ(keys.at("layer.0.albedo")->info->kind, ParameterKind::color);
  EXPECT_EQ(keys.at("layer.0.roughness")->map.scale, (std::array{0.1, 0.6}));
  EXPECT_EQ(keys.at("layer.0.axis")->map.encoding, MapEncoding::normal);
  EXPECT_EQ(keys.at("layer.0.axis")->map.scale, (std::array{-1.0, 1.0}));
  // Keys of closed forms are known elsewhere.
  EXPECT_FALSE(keys.at("substrate.albedo")->info);
}

TEST(MappedStack, IsTheStackThatIsWrittenWithItsValues) {
  const MappedStack mapped(kMapped, "a.toml", "a");
  std::vector<ParameterValue> values;
  for (const MappedKey& key : mapped.maps())
    values.push_back(key.key == "axis"        ? ParameterValue(std::vector<double>{0, 0.6, 0.8})
                     : key.key == "roughness" ? ParameterValue(0.25)
                     : key.layer              ? ParameterValue(Rgb(0.1, 0.2, 0.3))
                                              : ParameterValue(0.5));
  const Stack plain = parse_stack(
      "[[layer]]\nmedium = 'sggx'\nroughness = 0.25\naxis = [0, 0.6, 0.8]\n"
      "albedo = [0.1, 0.2, 0.3]\nthickness = 1\n[substrate]\nbsdf = 'eon'\nalbedo = 0.5\n",
      "a.toml", "a");
  // Twice: values do not stay.
  EXPECT_EQ(to_toml(mapped.with(values)), to_toml(plain));
  EXPECT_EQ(to_toml(mapped.with(values)), to_toml(plain));
}

TEST(MappedStack, HasNoPlainStack) {
  const MappedStack mapped(kMapped, "a.toml", "a");
  EXPECT_THROW((void)mapped.plain(), StackFileError);
  EXPECT_THROW((void)parse_stack(kMapped, "a.toml", "a"), StackFileError);
}

TEST(MappedStack, RefusesPicturesWhereTheyMeanNothing) {
  const std::string head = "[[layer]]\nmedium = 'sggx'\nthickness = 1\n";
  for (const auto& [line, part] : std::vector<std::pair<std::string, std::string>>{
           {"shape = 'a.png'", "found the picture \"a.png\"; allowed: one of"},
           {"matrix = 'a.png'", "six numbers"},
           {"axis = 'a.png'", "encoding = \"normal\" or \"angle\""},
           {"albedo = { map = 'a.png', encoding = 'angle' }", "encoding = \"value\""},
           {"albedo = { map = 'a.tif' }", "found \"a.tif\""},
           {"albedo = { map = 2 }", "found 2"},
           {"albedo = { map = 'a.png', filter = 'cubic' }", "linear, nearest"},
           {"albedo = { map = 'a.png', scale = [0, inf] }", "two finite numbers"}}) {
    const std::string error = refusal(head + line + "\n");
    EXPECT_NE(error.find("folder/a.toml:4: layer 0: key"), std::string::npos) << line << error;
    EXPECT_NE(error.find(part), std::string::npos) << line << ": " << error;
  }
}

}  // namespace lamella::testing
