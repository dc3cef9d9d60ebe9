#include "compare/files/exr_parts.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTileDescription.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <mutex>
#include <system_error>

#include "compare/files/exr_header_sizes.h"
#include "compare/files/output_folder.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

// Pixels along a side of a data window. The library refuses more before it allocates.
constexpr int kLongestSide = 1 << 17;
// Lines that a block of any compression has at most (DWAB).
constexpr std::int64_t kMostLines = 256;

std::string in_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// Runs `read` with what the system and the library say against the file as one line.
template <class Read>
auto reading(const fs::path& path, const Read& read) {
  static std::once_flag limited;
  std::call_once(limited, [] { Imf::Header::setMaxImageSize(kLongestSide, kLongestSide); });
  if (::access(path.c_str(), R_OK) != 0)
    throw OutputError(
        fmt::format("cannot read {}: {}", path.string(), std::generic_category().message(errno)));
  try {
    check_exr_header_sizes(path);
    return read();
  } catch (const std::exception& e) {
    throw OutputError(in_one_line(fmt::format("cannot read {}: {}", path.string(), e.what())));
  }
}

ExrWindow window_of(const Imath::Box2i& box) {
  return {box.min.x, box.min.y, box.max.x, box.max.y};
}

std::string kind_of(const Imf::Header& header) {
  if (header.hasType()) return header.type();
  return header.hasTileDescription() ? "tiledimage" : "scanlineimage";
}

ExrPart part_of(const Imf::Header& header) {
  ExrPart part;
  if (header.hasName()) part.name = header.name();
  part.kind = kind_of(header);
  part.data = window_of(header.dataWindow());
  part.display = window_of(header.displayWindow());
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    const Imf::Channel& channel = c.channel();
    part.channels.push_back({c.name(),
                             channel.type == Imf::HALF    ? "half"
                             : channel.type == Imf::FLOAT ? "float"
                                                          : "uint",
                             channel.xSampling == 1 && channel.ySampling == 1});
  }
  for (auto a = header.begin(); a != header.end(); ++a) {
    const std::string name = a.name();
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute()))
      if (name != "type" && name != "name") part.attributes[name] = text->value();
  }
  return part;
}

// Throws std::runtime_error where pixels or buffers would take more than kMostExrBytes.
void check_size(const Imf::Header& header, const ExrPart& part,
                const std::vector<std::string>& names) {
  const std::int64_t width = part.data.width(), height = part.data.height();
  const std::int64_t most = kMostExrBytes / (4 * std::max<std::int64_t>(std::ssize(names), 1));
  if (width * height > most)
    throw std::runtime_error(
        fmt::format("its data window is {}; allowed: at most {} pixels of {} channels",
                    part.data.text(), most, names.size()));
  const std::int64_t lines = header.hasTileDescription()
                                 ? std::min<std::int64_t>(header.tileDescription().ySize, height)
                                 : std::min(kMostLines, height);
  const auto all = static_cast<std::int64_t>(4 * part.channels.size());
  if (width > kMostExrBytes / std::max<std::int64_t>(lines * all, 1))
    throw std::runtime_error(
        fmt::format("its data window is {} with {} channels: a row of blocks takes more than 1 GiB",
                    part.data.text(), part.channels.size()));
}

ExrImage decode(const fs::path& path, int index, const std::vector<std::string>& names) {
  Imf::MultiPartInputFile file(path.c_str(), 0);
  if (index < 0 || index >= file.parts())
    throw std::runtime_error(fmt::format("it has no part {}", index));
  const Imf::Header& header = file.header(index);
  const ExrPart part = part_of(header);
  if (part.is_deep()) throw std::runtime_error(fmt::format("its part {} is deep", index));
  check_size(header, part, names);
  ExrImage image;
  image.width = static_cast<int>(part.data.width());
  image.height = static_cast<int>(part.data.height());
  image.attributes = part.attributes;
  const auto width = static_cast<std::size_t>(image.width);
  const std::size_t pixels = width * static_cast<std::size_t>(image.height);
  for (const std::string& name : names) {
    const auto channel = std::find_if(part.channels.begin(), part.channels.end(),
                                      [&](const ExrChannel& c) { return c.name == name; });
    if (channel == part.channels.end())
      throw std::runtime_error(fmt::format("it has no channel {}", name));
    if (!channel->every_pixel)
      throw std::runtime_error(fmt::format("its channel {} is subsampled", name));
    image.channels.emplace_back(name, std::vector<float>(pixels));
  }
  Imf::FrameBuffer frame;
  for (auto& [name, values] : image.channels)
    frame.insert(name.c_str(), Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow(),
                                                sizeof(float), width * sizeof(float)));
  Imf::InputPart input(file, index);
  input.setFrameBuffer(frame);
  input.readPixels(part.data.top, part.data.bottom);
  return image;
}

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::string layer_of(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  return dot == std::string::npos ? "" : channel.substr(0, dot);
}

std::string last_name(const std::string& channel) {
  return lower(channel.substr(channel.rfind('.') + 1));
}

// The picture that the channels of one layer of a part are, if they are one.
std::vector<std::string> picture_of(const ExrPart& part, const std::string& layer) {
  const auto find = [&](std::initializer_list<const char*> names) -> std::string {
    for (const char* name : names)
      for (const ExrChannel& c : part.channels)
        if (layer_of(c.name) == layer && last_name(c.name) == name) return c.name;
    return "";
  };
  std::vector<std::string> colors{find({"r", "red"}), find({"g", "green"}), find({"b", "blue"})};
  if (std::none_of(colors.begin(), colors.end(), [](const auto& c) { return c.empty(); }))
    return colors;
  const std::string y = find({"y"});
  if (y.empty() || !find({"x", "z", "ry", "by"}).empty()) return {};
  return {y};
}

// Smaller comes first.
int rank_of(const ExrColors& colors) {
  static const std::vector<std::string> kFinal{"combined", "beauty", "rgb",
                                               "rgba",     "color",  "colour"};
  const bool named =
      std::find(kFinal.begin(), kFinal.end(), last_name(colors.layer)) != kFinal.end();
  return (colors.channels.size() == 3 ? 0 : 3) + (colors.layer.empty() ? 0 : named ? 1 : 2);
}

}  // namespace

std::string ExrWindow::text() const {
  return fmt::format("{} x {} from ({}, {})", width(), height(), left, top);
}

std::vector<ExrPart> read_exr_parts(const fs::path& path) {
  return reading(path, [&] {
    Imf::MultiPartInputFile file(path.c_str(), 0);
    std::vector<ExrPart> parts;
    for (int k = 0; k < file.parts(); ++k) parts.push_back(part_of(file.header(k)));
    return parts;
  });
}

ExrImage read_exr_part(const fs::path& path, int part, const std::vector<std::string>& channels) {
  return reading(path, [&] { return decode(path, part, channels); });
}

std::vector<ExrColors> find_colors(const std::vector<ExrPart>& parts) {
  std::vector<ExrColors> found;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].is_deep()) continue;
    std::vector<std::string> layers;
    for (const ExrChannel& c : parts[k].channels)
      if (std::find(layers.begin(), layers.end(), layer_of(c.name)) == layers.end())
        layers.push_back(layer_of(c.name));
    for (const std::string& layer : layers)
      if (auto channels = picture_of(parts[k], layer); !channels.empty())
        found.push_back({static_cast<int>(k), layer, std::move(channels)});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const ExrColors& a, const ExrColors& b) { return rank_of(a) < rank_of(b); });
  return found;
}

std::string channels_text(const std::vector<ExrPart>& parts) {
  constexpr std::size_t kMostChannels = 24;
  std::string text;
  std::size_t told = 0, all = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    std::string names;
    all += parts[k].channels.size();
    for (const ExrChannel& c : parts[k].channels)
      if (told < kMostChannels) {
        names += (names.empty() ? "" : ", ") + c.name;
        ++told;
      }
    if (names.empty()) continue;
    if (!text.empty()) text += "; ";
    if (parts.size() > 1)
      text += fmt::format("part {}{}: ", k,
                          parts[k].name.empty() ? "" : fmt::format(" \"{}\"", parts[k].name));
    text += names + (parts[k].is_deep() ? " (deep)" : "");
  }
  if (told < all) text += fmt::format(" and {} more", all - told);
  return in_one_line(text.empty() ? "none" : text);
}

}  // namespace lamella
