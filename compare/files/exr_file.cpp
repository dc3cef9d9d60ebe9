#include "compare/files/exr_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "compare/files/exr_parts.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

/// A file in memory: whole, it can be written in one piece by write_file.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : OStream("memory") {}
  void write(const char c[], int n) override {
    const auto count = static_cast<std::size_t>(n);
    if (bytes_.size() < position_ + count) bytes_.resize(position_ + count);
    std::copy_n(c, count, bytes_.begin() + static_cast<std::ptrdiff_t>(position_));
    position_ += count;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

/// What is wrong with an image, or nothing.
std::optional<std::string> defect(const ExrImage& image) {
  if (image.width < 1 || image.height < 1)
    return fmt::format("an image of {} x {} has no pixels", image.width, image.height);
  if (image.channels.empty()) return "an image without channels";
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  std::map<std::string, int> uses;
  for (const auto& [name, values] : image.channels) {
    if (name.empty()) return "a channel without a name";
    if (++uses[name] > 1) return fmt::format("two channels are named {}", name);
    if (values.size() != pixels)
      return fmt::format("channel {} has {} values instead of {}", name, values.size(), pixels);
    const auto bad =
        std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
    if (bad != values.end()) {
      const auto at = bad - values.begin();
      return fmt::format("channel {} holds {} at x = {}, y = {}", name, *bad, at % image.width,
                         at / image.width);
    }
  }
  return std::nullopt;
}

std::string encode(const ExrImage& image) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [name, text] : image.attributes) {
    if (header.find(name.c_str()) != header.end() || name == "type")
      throw OutputError(fmt::format("the attribute name {} is EXR's own", name));
    header.insert(name.c_str(), Imf::StringAttribute(text));
  }
  Imf::FrameBuffer frame;
  const auto width = static_cast<std::size_t>(image.width);
  for (const auto& [name, values] : image.channels) {
    header.channels().insert(name.c_str(), Imf::Channel(Imf::FLOAT));
    // OpenEXR's interface for writing takes pointers to what it only reads.
    auto* data = reinterpret_cast<char*>(const_cast<float*>(values.data()));
    frame.insert(name.c_str(), Imf::Slice(Imf::FLOAT, data, sizeof(float), width * sizeof(float)));
  }
  MemoryStream stream;
  {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
  }
  return stream.bytes();
}

}  // namespace

void write_exr(const fs::path& path, const ExrImage& image) {
  if (const auto reason = defect(image))
    throw OutputError(fmt::format("cannot write {}: {}", path.string(), *reason));
  std::string bytes;
  try {
    bytes = encode(image);
  } catch (const std::exception& e) {
    throw OutputError(fmt::format("cannot write {}: {}", path.string(), e.what()));
  }
  write_file(path, bytes);
}

ExrImage read_exr(const fs::path& path) {
  const std::vector<ExrPart> parts = read_exr_parts(path);
  std::vector<std::string> names;
  for (const ExrChannel& channel : parts.front().channels) names.push_back(channel.name);
  return read_exr_part(path, 0, names);
}

std::vector<float> exr_values(std::span<const double> values) {
  std::vector<float> floats;
  floats.reserve(values.size());
  for (const double v : values) {
    if (!(std::fabs(v) <= static_cast<double>(std::numeric_limits<float>::max())))
      throw OutputError(fmt::format("the value {} at index {} is not a float", v, floats.size()));
    floats.push_back(static_cast<float>(v));
  }
  return floats;
}

std::string channel_name(int direction, std::string_view side, std::string_view lobe,
                         std::string_view part, std::string_view channel) {
  return fmt::format("wi{}.{}.{}.{}{}{}", direction, side, lobe, part, part.empty() ? "" : ".",
                     channel);
}

void add_plain_channels(ExrImage& image) {
  const auto find = [&](const std::string& name) {
    return std::find_if(image.channels.begin(), image.channels.end(),
                        [&](const auto& channel) { return channel.first == name; });
  };
  for (const std::string plain : {"R", "G", "B", "Y"}) {
    const auto source = find(channel_name(0, "reflect", "all", "", plain));
    if (source == image.channels.end() || find(plain) != image.channels.end()) continue;
    std::vector<float> values = source->second;
    image.channels.emplace_back(plain, std::move(values));
  }
}

}  // namespace lamella
