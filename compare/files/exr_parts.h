#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compare/files/exr_image.h"

namespace lamella {

/// Bytes of pixels that are read at a time, and that the library may hold beside them.
inline constexpr std::int64_t kMostExrBytes = std::int64_t{1} << 30;

/// A window of an EXR file: pixels from the first to the last, both of them inside.
struct ExrWindow {
  int left = 0, top = 0, right = 0, bottom = 0;
  [[nodiscard]] std::int64_t width() const { return std::int64_t{right} - left + 1; }
  [[nodiscard]] std::int64_t height() const { return std::int64_t{bottom} - top + 1; }
  /// "1024 x 512 from (0, 0)"
  [[nodiscard]] std::string text() const;
};

/// A channel as the header describes it.
struct ExrChannel {
  std::string name;
  std::string type;         ///< "half", "float" or "uint"
  bool every_pixel = true;  ///< false: subsampled, as the colours of luminance/chroma files are
};

/// A part as its header describes it. Files of one part have one without a name.
struct ExrPart {
  std::string name;
  std::string kind;   ///< "scanlineimage", "tiledimage", "deepscanline" or "deeptile"
  ExrWindow data;     ///< the pixels that the file holds
  ExrWindow display;  ///< the picture; pixels outside of `data` are black
  std::vector<ExrChannel> channels;
  std::map<std::string, std::string> attributes;  ///< those that are strings

  [[nodiscard]] bool is_deep() const { return kind.starts_with("deep"); }
};

/// The headers of all parts, in the file's order; no pixels. Throws OutputError.
[[nodiscard]] std::vector<ExrPart> read_exr_parts(const std::filesystem::path& path);

/// The data window of a part, with the channels of these names, in this order; half and uint pixels
/// become floats, and tiles the picture that they cover at full resolution. Throws OutputError:
/// also for deep parts, for subsampled channels, and before it allocates more than kMostExrBytes.
[[nodiscard]] ExrImage read_exr_part(const std::filesystem::path& path, int part,
                                     const std::vector<std::string>& channels);

/// Three channels that are a colour picture, or one that is its luminance.
struct ExrColors {
  int part = 0;
  std::string layer;                  ///< "ViewLayer.Combined"; empty: channels without a layer
  std::vector<std::string> channels;  ///< names of red, green, blue; or of the luminance alone
};

/// Where a file has its picture: channels R, G, B of any part and layer, upper or lower case, or
/// red, green, blue; without them a luminance Y (which is none beside X and Z, nor beside RY and
/// BY). Channels without a layer come first, then layers whose last name is combined, beauty, rgb,
/// rgba, color or colour, then the others, each in the file's order. Empty if there is none.
[[nodiscard]] std::vector<ExrColors> find_colors(const std::vector<ExrPart>& parts);

/// The channels of all parts in one line, shortened where they are many: "part 1 \"depth\": Z;
/// ...".
[[nodiscard]] std::string channels_text(const std::vector<ExrPart>& parts);

}  // namespace lamella
