#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

namespace lamella {

/// Pixels of a picture that is read, and of all channels: 64 million and 1 GiB at most.
inline constexpr std::int64_t kMostPicturePixels = std::int64_t{1} << 26;

/// A picture: numbers row by row from the top left, the channels of a pixel side by side.
struct Picture {
  int width = 0, height = 0;
  int channels = 0;      ///< 1 grey, 2 grey and alpha, 3 red, green, blue, 4 with alpha
  bool integer = false;  ///< of PNG and JPEG: whole numbers over the largest one, in [0, 1]
  std::vector<float> values{};

  [[nodiscard]] const float* pixel(int x, int y) const {
    return values.data() + (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(x)) *
                               static_cast<std::size_t>(channels);
  }
};

/// Reads OpenEXR (the display window of the first part and layer that has colours; no alpha), PNG
/// of 1 to 16 bits, or JPEG, whichever the file's first bytes say. Values are as they are stored:
/// no gamma is taken from the file. Throws OutputError: for what is none of them, for damaged
/// files, and before it allocates for more than kMostPicturePixels. What a file of several pictures
/// holds besides is left out.
[[nodiscard]] Picture read_picture(const std::filesystem::path& path);

/// Whether this program was built with libpng and libjpeg.
[[nodiscard]] bool has_png_and_jpeg();

/// The same of a file's bytes. `name`: for errors. Without libpng and libjpeg
/// (-DLAMELLA_PICTURES=OFF) they refuse.
[[nodiscard]] Picture read_png(std::string_view bytes, const std::filesystem::path& name);
[[nodiscard]] Picture read_jpeg(std::string_view bytes, const std::filesystem::path& name);

/// Throws OutputError for sizes beyond the bounds.
void check_picture_size(std::int64_t width, std::int64_t height, int channels,
                        const std::filesystem::path& name);

}  // namespace lamella
