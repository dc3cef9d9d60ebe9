#include "compare/files/picture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "compare/files/exr_parts.h"
#include "compare/files/output_error.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

// Bytes of a PNG or JPEG file that are read.
constexpr std::uintmax_t kMostFileBytes = std::uintmax_t{256} << 20;

Picture read_exr_picture(const fs::path& path) {
  const std::vector<ExrPart> parts = read_exr_parts(path);
  const std::vector<ExrColors> found = find_colors(parts);
  if (found.empty())
    throw OutputError(
        fmt::format("cannot read {}: found the channels {}; allowed: R, G, B in any part or layer, "
                    "or Y",
                    path.string(), channels_text(parts)));
  const ExrColors& colors = found.front();
  const ExrPart& part = parts[static_cast<std::size_t>(colors.part)];
  const ExrWindow &data = part.data, &display = part.display;
  Picture picture;
  picture.channels = static_cast<int>(colors.channels.size());
  check_picture_size(display.width(), display.height(), picture.channels, path);
  const ExrImage image = read_exr_part(path, colors.part, colors.channels);
  picture.width = static_cast<int>(display.width());
  picture.height = static_cast<int>(display.height());
  picture.values.assign(static_cast<std::size_t>(picture.width) *
                            static_cast<std::size_t>(picture.height) *
                            static_cast<std::size_t>(picture.channels),
                        0);
  for (int y = std::max(data.top, display.top); y <= std::min(data.bottom, display.bottom); ++y)
    for (int x = std::max(data.left, display.left); x <= std::min(data.right, display.right); ++x)
      for (int c = 0; c < picture.channels; ++c) {
        const auto from =
            static_cast<std::size_t>(y - data.top) * static_cast<std::size_t>(image.width) +
            static_cast<std::size_t>(x - data.left);
        const auto to =
            (static_cast<std::size_t>(y - display.top) * static_cast<std::size_t>(picture.width) +
             static_cast<std::size_t>(x - display.left)) *
                static_cast<std::size_t>(picture.channels) +
            static_cast<std::size_t>(c);
        picture.values[to] = image.channels[static_cast<std::size_t>(c)].second[from];
      }
  return picture;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(fs::file_size(path)), '\0');
  if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    throw OutputError(fmt::format("cannot read {}: it ends early", path.string()));
  return bytes;
}

}  // namespace

void check_picture_size(std::int64_t width, std::int64_t height, int channels,
                        const fs::path& name) {
  constexpr std::int64_t kMostNumbers = std::int64_t{1} << 28;
  if (width < 1 || height < 1 || width > kMostPicturePixels / height ||
      width * height * channels > kMostNumbers)
    throw OutputError(
        fmt::format("cannot read {}: found {} x {} pixels of {} channels; allowed: at most {} "
                    "pixels and {} numbers",
                    name.string(), width, height, channels, kMostPicturePixels, kMostNumbers));
}

Picture read_picture(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw OutputError(
        fmt::format("cannot read {}: {}", path.string(),
                    fs::exists(path, error) ? "it is no file" : "No such file or directory"));
  std::ifstream in(path, std::ios::binary);
  std::string first(4, '\0');
  in.read(first.data(), 4);
  if (!in) throw OutputError(fmt::format("cannot read {}: it is no picture", path.string()));
  if (first == "\x76\x2f\x31\x01") return read_exr_picture(path);
  const bool png = first == "\x89PNG", jpeg = first.starts_with("\xff\xd8\xff");
  if (!png && !jpeg)
    throw OutputError(
        fmt::format("cannot read {}: it is neither OpenEXR nor PNG nor JPEG", path.string()));
  if (const std::uintmax_t size = fs::file_size(path); size > kMostFileBytes)
    throw OutputError(fmt::format("cannot read {}: found {} bytes; allowed: at most {}",
                                  path.string(), size, kMostFileBytes));
  return png ? read_png(bytes_of(path), path) : read_jpeg(bytes_of(path), path);
}

}  // namespace lamella
