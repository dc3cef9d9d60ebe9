#include "compare/maps/value_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "compare/files/output_error.h"
#include "compare/files/picture_file.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

// IEC 61966-2-1.
double linear_from_srgb(double x) {
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

std::int64_t wrapped_index(std::int64_t k, std::int64_t count, MapWrap wrap) {
  const auto modulo = [](std::int64_t a, std::int64_t n) { return (a % n + n) % n; };
  if (wrap == MapWrap::clamp) return std::clamp<std::int64_t>(k, 0, count - 1);
  if (wrap == MapWrap::repeat) return modulo(k, count);
  const std::int64_t in = modulo(k, 2 * count);
  return in < count ? in : 2 * count - 1 - in;
}

Picture picture_of(const MappedKey& key, const std::filesystem::path& file) {
  try {
    return read_picture(file);
  } catch (const OutputError& error) {
    throw StackFileError(fmt::format("{}: {}", key.where, error.what()));
  }
}

// Reads numbers of a key from a pixel.
class PixelDecoder {
 public:
  PixelDecoder(const MappedKey& key, const Picture& picture) : map_(key.map) {
    const bool colored = picture.channels >= 3;
    const bool takes_color =
        key.info ? key.info->kind == ParameterKind::color : map_.channel == MapChannel::automatic;
    const bool direction = map_.encoding == MapEncoding::normal;
    if (direction && !colored)
      refuse(key, "a grey picture", "three channels, or encoding = \"angle\"");
    if (map_.channel != MapChannel::automatic) {
      if (direction) refuse(key, "a channel beside encoding = \"normal\"", "no channel");
      channel_ = static_cast<int>(map_.channel) - 1;
      const bool alpha = map_.channel == MapChannel::alpha;
      if (alpha) channel_ = picture.channels - 1;
      if (alpha ? picture.channels % 2 != 0 : channel_ > 0 && !colored)
        refuse(key, fmt::format("a picture of {} channels", picture.channels),
               "a channel that it has");
    }
    numbers_ = direction || (colored && takes_color && channel_ < 0) ? 3 : 1;
    grey_ = !colored;
    srgb_ = map_.color_space == MapColorSpace::srgb ||
            (map_.color_space == MapColorSpace::automatic && picture.integer && takes_color &&
             map_.encoding == MapEncoding::value && map_.channel == MapChannel::automatic);
  }

  /// Numbers of an undecoded pixel, 1 or 3; of a texel, with angles as directions.
  [[nodiscard]] int texel_numbers() const {
    return map_.encoding == MapEncoding::angle ? 3 : numbers_;
  }

  [[nodiscard]] std::array<double, 3> operator()(const float* pixel) const {
    const auto scaled = [&](double x) {
      return map_.scale[0] + (map_.scale[1] - map_.scale[0]) * x;
    };
    const auto linear = [&](double x) { return srgb_ ? linear_from_srgb(x) : x; };
    std::array<double, 3> out{};
    if (numbers_ == 3) {
      for (std::size_t c = 0; c < 3; ++c) out[c] = scaled(linear(pixel[c]));
      return out;
    }
    out[0] = scaled(channel_ >= 0 ? linear(pixel[channel_])
                    : grey_       ? linear(pixel[0])
                            : luminance(Rgb(linear(pixel[0]), linear(pixel[1]), linear(pixel[2]))));
    if (map_.encoding == MapEncoding::angle) {
      const double angle = out[0] * kPi / 180;
      out = {std::cos(angle), std::sin(angle), 0};
    }
    return out;
  }

 private:
  [[noreturn]] static void refuse(const MappedKey& key, const std::string& found,
                                  const std::string& allowed) {
    throw StackFileError(
        fmt::format("{}: found {} ({}); allowed: {}", key.where, found, key.map.file, allowed));
  }

  MapReference map_;
  int channel_ = -1;  // -1: as the key takes it
  int numbers_ = 1;
  bool grey_ = false, srgb_ = false;
};

}  // namespace

ValueMap::ValueMap(const MappedKey& key)
    : key_(key), file_(std::filesystem::path(key.map.folder) / key.map.file) {
  const Picture picture = picture_of(key, file_);
  const PixelDecoder decode(key, picture);
  columns_ = picture.width;
  rows_ = picture.height;
  numbers_ = decode.texel_numbers();
  const std::size_t count = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  texels_.resize(count * static_cast<std::size_t>(numbers_));
  for (std::size_t k = 0; k < count; ++k) {
    const auto numbers =
        decode(picture.values.data() + k * static_cast<std::size_t>(picture.channels));
    for (int c = 0; c < numbers_; ++c)
      texels_[k * static_cast<std::size_t>(numbers_) + static_cast<std::size_t>(c)] =
          static_cast<float>(numbers[static_cast<std::size_t>(c)]);
  }
  check();
}

// Ranges are intervals: the extremes of each number are allowed if and only if all are.
void ValueMap::check() const {
  const auto refuse = [&](std::size_t at, const std::string& found, const std::string& allowed) {
    const std::size_t pixel = at / static_cast<std::size_t>(numbers_);
    throw StackFileError(fmt::format("{}: found {} at pixel ({}, {}) of {}; allowed: {}",
                                     key_.where, found, pixel % static_cast<std::size_t>(columns_),
                                     pixel / static_cast<std::size_t>(columns_), key_.map.file,
                                     allowed));
  };
  std::size_t least = 0, most = 0;
  for (std::size_t k = 0; k < texels_.size(); ++k) {
    if (!std::isfinite(texels_[k]))
      refuse(k, to_text(static_cast<double>(texels_[k])), "finite numbers");
    if (texels_[k] < texels_[least]) least = k;
    if (texels_[k] > texels_[most]) most = k;
  }
  if (key_.map.encoding == MapEncoding::normal) {
    for (std::size_t k = 0; k < texels_.size(); k += 3)
      if (texels_[k] == 0 && texels_[k + 1] == 0 && texels_[k + 2] == 0)
        refuse(k, "no direction", "three numbers, not all zero");
    return;
  }
  if (!key_.info || key_.map.encoding == MapEncoding::angle) return;
  for (const std::size_t k : {least, most}) {
    try {
      (void)checked(*key_.info, static_cast<double>(texels_[k]));
    } catch (const ParameterError& error) {
      refuse(k, error.found, error.allowed);
    }
  }
}

const float* ValueMap::texel(std::int64_t x, std::int64_t y) const {
  const std::int64_t column = wrapped_index(x, columns_, key_.map.wrap),
                     row = wrapped_index(y, rows_, key_.map.wrap);
  return texels_.data() +
         static_cast<std::size_t>(row * columns_ + column) * static_cast<std::size_t>(numbers_);
}

ParameterValue ValueMap::value_of(const double* numbers) const {
  ParameterValue value = numbers[0];
  if (numbers_ == 3) value = std::vector<double>{numbers[0], numbers[1], numbers[2]};
  if (!key_.info) return value;
  try {
    return checked(*key_.info, value);
  } catch (const ParameterError& error) {
    throw StackFileError(fmt::format("{}: found {} between the pixels of {}; allowed: {}",
                                     key_.where, error.found, key_.map.file, error.allowed));
  }
}

ParameterValue ValueMap::at(double u, double v) const {
  // Whole repetitions aside, so that any number is in range of an index.
  const double period = key_.map.wrap == MapWrap::mirror ? 2 : 1;
  if (key_.map.wrap == MapWrap::clamp) {
    u = std::clamp(u, 0.0, 1.0);
    v = std::clamp(v, 0.0, 1.0);
  } else {
    u -= period * std::floor(u / period);
    v -= period * std::floor(v / period);
  }
  std::array<double, 3> numbers{};
  if (key_.map.filter == MapFilter::nearest) {
    const auto x = static_cast<std::int64_t>(std::floor(u * columns_));
    const auto y = static_cast<std::int64_t>(std::floor(v * rows_));
    const float* t = texel(x, rows_ - 1 - y);
    std::copy_n(t, numbers_, numbers.begin());
    return value_of(numbers.data());
  }
  const double x = u * columns_ - 0.5, y = (1 - v) * rows_ - 0.5;
  const double left = std::floor(x), top = std::floor(y);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double weight = (i ? x - left : 1 - (x - left)) * (j ? y - top : 1 - (y - top));
      const float* t =
          texel(static_cast<std::int64_t>(left) + i, static_cast<std::int64_t>(top) + j);
      for (std::size_t c = 0; c < static_cast<std::size_t>(numbers_); ++c)
        numbers[c] += weight * static_cast<double>(t[c]);
    }
  // Rounding takes a mean of equal numbers past them.
  if (key_.info && numbers_ == 1)
    numbers[0] = std::clamp(numbers[0], key_.info->min, key_.info->max);
  if (key_.info && key_.info->kind == ParameterKind::color)
    for (double& x_of : numbers) x_of = std::clamp(x_of, key_.info->min, key_.info->max);
  return value_of(numbers.data());
}

}  // namespace lamella
