#include "phase/stack/map_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "phase/grains/grain_geometry.h"
#include "phase/interface/interfaces.h"
#include "phase/medium/media.h"
#include "phase/stack/layer_keys.h"
#include "phase/stack/stack.h"

namespace lamella {
namespace {

// The values of a word's key, in the order of the enumeration.
template <class Word, std::size_t N>
Word read_word(const KeyReader& keys, const toml::node& node, const std::string& where,
               const std::string& key, const std::array<const char*, N>& words) {
  const auto* word = node.as_string();
  for (std::size_t k = 0; word && k < N; ++k)
    if (word->get() == words[k]) return static_cast<Word>(k);
  keys.fail(node.source(), fmt::format("{}: key \"{}\": found {}; allowed: one of {}", where, key,
                                       described(node), fmt::join(words, ", ")));
}

constexpr std::array kEncodings{"value", "normal", "angle"};
constexpr std::array kWraps{"repeat", "mirror", "clamp"};
constexpr std::array kFilters{"linear", "nearest"};
constexpr std::array kColorSpaces{"auto", "linear", "srgb"};
constexpr std::array kChannels{"auto", "r", "g", "b", "a"};
constexpr const char* kPictures = "the name of a .exr, .png or .jpg file";

bool is_picture_name(const std::string& text) {
  std::string ending = std::filesystem::path(text).extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return ending == ".exr" || ending == ".png" || ending == ".jpg" || ending == ".jpeg";
}

std::array<double, 2> read_scale(const KeyReader& keys, const toml::node& node,
                                 const std::string& where) {
  if (const auto value = to_value(node))
    if (const auto* list = std::get_if<std::vector<double>>(&*value);
        list && list->size() == 2 && std::isfinite((*list)[0]) && std::isfinite((*list)[1]))
      return {(*list)[0], (*list)[1]};
  keys.fail(node.source(),
            fmt::format("{}: key \"scale\": found {}; allowed: two finite numbers [value of 0, "
                        "value of 1]",
                        where, text_of(node)));
}

}  // namespace

bool names_picture(const toml::node& node) {
  if (const auto* text = node.as_string()) return is_picture_name(text->get());
  const auto* table = node.as_table();
  return table && table->contains("map");
}

MapReference read_map(const KeyReader& keys, const toml::node& node, const std::string& where,
                      const std::string& key) {
  MapReference map;
  map.folder = std::filesystem::path(keys.file()).parent_path().string();
  const toml::table* table = node.as_table();
  const std::string inside = fmt::format("{}: key \"{}\"", where, key);
  const toml::node& name = table ? *table->get("map") : node;
  map.file = keys.read_name(name, table ? inside : where, table ? "map" : key, kPictures);
  if (!is_picture_name(map.file))
    keys.fail(name.source(), fmt::format("{}: key \"map\": found \"{}\"; allowed: {}", inside,
                                         map.file, kPictures));
  bool scaled = false;
  if (table)
    for (const auto& [word, value] : *table) {
      const std::string_view k = word.str();
      if (k == "map") continue;
      if (k == "scale") {
        map.scale = read_scale(keys, value, inside);
        scaled = true;
      } else if (k == "encoding") {
        map.encoding = read_word<MapEncoding>(keys, value, inside, "encoding", kEncodings);
      } else if (k == "wrap") {
        map.wrap = read_word<MapWrap>(keys, value, inside, "wrap", kWraps);
      } else if (k == "filter") {
        map.filter = read_word<MapFilter>(keys, value, inside, "filter", kFilters);
      } else if (k == "color_space") {
        map.color_space =
            read_word<MapColorSpace>(keys, value, inside, "color_space", kColorSpaces);
      } else if (k == "channel") {
        map.channel = read_word<MapChannel>(keys, value, inside, "channel", kChannels);
      } else {
        keys.fail(
            word.source(),
            unknown_key(k, {"map", "scale", "encoding", "wrap", "filter", "color_space", "channel"},
                        inside));
      }
    }
  if (!scaled && map.encoding == MapEncoding::normal) map.scale = {-1, 1};
  if (!scaled && map.encoding == MapEncoding::angle) map.scale = {0, 360};
  return map;
}

std::optional<ParameterInfo> known_key(const toml::table& table, bool substrate,
                                       std::string_view key) {
  std::vector<ParameterInfo> infos;
  const auto named = [&](const char* what) { return table[what].value<std::string>(); };
  if (substrate) {
    const auto bsdf = named("bsdf");
    if (bsdf == kConductor) infos = conductor_parameters();
    if (!bsdf || bsdf == "lambert" || bsdf == "black") infos = {albedo_key()};
  } else if (const auto interface = named("interface")) {
    if (const InterfaceInfo* info = find_interface(*interface)) infos = info->parameters;
  } else if (const auto medium = named("medium")) {
    if (const GeometryInfo* geometry = find_geometry(*medium)) {
      infos = geometry->parameters;
      infos.push_back(albedo_key());
    } else if (const MediumInfo* info = find_medium(*medium)) {
      infos = info->parameters;
      infos.insert(infos.end(), {albedo_key(), thickness_key(), density_key()});
    }
  }
  const ParameterInfo* info = find(infos, key);
  return info ? std::optional(*info) : std::nullopt;
}

}  // namespace lamella
