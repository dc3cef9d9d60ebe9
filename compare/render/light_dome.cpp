#include "compare/render/light_dome.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/files/output_error.h"
#include "compare/files/picture_file.h"
#include "compare/request/errors.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

constexpr int kSkyColumns = 256, kSkyRows = 128;
// The ground's radiance, of a grey albedo under a sky that gives it the irradiance pi.
constexpr double kGround = 0.2;
// Bluish, of luminance 1.
constexpr Rgb kClearTint{0.735, 1.000, 1.780};

// Parameters of the CIE's sky types (CIE S 011/E:2003, table 1): gradation a, b; indicatrix c, d,
// e.
struct SkyType {
  double a, b, c, d, e;
};
constexpr SkyType kOvercast{4, -0.7, 0, -1, 0}, kClear{-1, -0.32, 10, -3, 0.45};

double relative_luminance(const SkyType& s, double cosine_zenith, double cosine_sun) {
  const double angle = std::acos(std::clamp(cosine_sun, -1.0, 1.0));
  const double gradation = 1 + s.a * std::exp(s.b / std::max(cosine_zenith, 0.01));
  return gradation * (1 + s.c * (std::exp(s.d * angle) - std::exp(s.d * kPi / 2)) +
                      s.e * cosine_sun * cosine_sun);
}

Direction middle_of(int column, int row, int columns, int rows) {
  const double theta = kPi * (row + 0.5) / rows, l = kPi * ((2 * column + 1.0) / columns - 1);
  return {std::sin(theta) * std::sin(l), std::cos(theta), -std::sin(theta) * std::cos(l)};
}

// 1 - cos of the lamp's radius.
const double kLampHeight = 2 * std::pow(std::sin(LightDome::kLampRadius / 2), 2);
// The irradiance of the disc is pi sin^2 times its radiance.
const double kLampRadiance = 1 / std::pow(std::sin(LightDome::kLampRadius), 2);

}  // namespace

std::vector<Rgb> sky_texels(SkyKind sky, int columns, int rows, Direction sun) {
  std::vector<Rgb> texels(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows),
                          Rgb(sky == SkyKind::none ? 0 : 1));
  if (sky == SkyKind::uniform || sky == SkyKind::none) return texels;
  if (sun.y < 0) sun.y = -sun.y;
  double irradiance = 0;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const Direction w = middle_of(column, row, columns, rows);
      Rgb& texel = texels[static_cast<std::size_t>(row * columns + column)];
      if (w.y <= 0) continue;
      texel = Rgb(relative_luminance(sky == SkyKind::clear ? kClear : kOvercast, w.y, dot(w, sun)));
      const double solid_angle =
          2 * kPi / columns * (std::cos(kPi * row / rows) - std::cos(kPi * (row + 1) / rows));
      irradiance += texel.r * w.y * solid_angle;
    }
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      Rgb& texel = texels[static_cast<std::size_t>(row * columns + column)];
      if (middle_of(column, row, columns, rows).y <= 0)
        texel = Rgb(kGround);
      else
        texel = kPi / irradiance * (sky == SkyKind::clear ? texel * kClearTint : texel);
    }
  return texels;
}

LightDome::LightDome(SkyKind sky, std::optional<Direction> lamp) {
  if (sky == SkyKind::clear || sky == SkyKind::overcast) {
    columns_ = kSkyColumns;
    rows_ = kSkyRows;
  }
  texels_ = sky_texels(sky, columns_, rows_, lamp.value_or(Direction{0, 1, 0}));
  prepare(lamp);
}

LightDome::LightDome(const std::string& path, std::optional<Direction> lamp) {
  const Picture picture = [&] {
    try {
      return read_picture(path);
    } catch (const OutputError& error) {
      throw UsageError(fmt::format("--environment: {}", error.what()));
    }
  }();
  columns_ = picture.width;
  rows_ = picture.height;
  texels_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  const bool grey = picture.channels < 3;
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < columns_; ++x) {
      Rgb& texel = texels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
                           static_cast<std::size_t>(x)];
      const float* pixel = picture.pixel(x, y);
      for (int c = 0; c < 3; ++c) {
        texel[c] = static_cast<double>(pixel[grey ? 0 : c]);
        if (!(texel[c] >= 0 && std::isfinite(texel[c])))
          throw UsageError(
              fmt::format("--environment {}: found {} at pixel ({}, {}); allowed: finite numbers "
                          "from 0",
                          path, texel[c], x, y));
      }
    }
  prepare(lamp);
}

void LightDome::prepare(std::optional<Direction> lamp) {
  lamp_ = lamp;
  double sum = 0;
  for (std::size_t k = 0; k < texels_.size(); ++k) {
    sum += luminance(texels_[k]) * solid_angle(k / static_cast<std::size_t>(columns_));
    cumulative_.push_back(sum);
  }
  if (sum > 0)
    for (double& c : cumulative_) c /= sum;
  else
    cumulative_.clear();
  // As the irradiance: a surface sees half of the dome, at a mean cosine of a half.
  if (lamp_) lamp_share_ = cumulative_.empty() ? 1 : kPi / (kPi + sum / 4);
}

double LightDome::solid_angle(std::size_t row) const {
  const double from = kPi * static_cast<double>(row) / rows_;
  const double to = kPi * (static_cast<double>(row) + 1) / rows_;
  return 2 * kPi / columns_ * (std::cos(from) - std::cos(to));
}

bool LightDome::in_lamp(Direction w) const { return lamp_ && 1 - dot(w, *lamp_) < kLampHeight; }

std::size_t LightDome::texel_of(Direction w) const {
  const double theta = std::acos(std::clamp(w.y, -1.0, 1.0)), l = std::atan2(w.x, -w.z);
  const int row = std::clamp(static_cast<int>(theta / kPi * rows_), 0, rows_ - 1);
  const int column = std::clamp(static_cast<int>((l / kPi + 1) / 2 * columns_), 0, columns_ - 1);
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(column);
}

Rgb LightDome::radiance(Direction w) const {
  const Rgb sky = texels_[texel_of(w)];
  return in_lamp(w) ? sky + Rgb(kLampRadiance) : sky;
}

double LightDome::density(Direction w) const {
  double density = 0;
  if (!cumulative_.empty()) {
    const std::size_t k = texel_of(w);
    const double share = cumulative_[k] - (k ? cumulative_[k - 1] : 0);
    density += (1 - lamp_share_) * share / solid_angle(k / static_cast<std::size_t>(columns_));
  }
  if (in_lamp(w)) density += lamp_share_ / (2 * kPi * kLampHeight);
  return density;
}

std::optional<LightDome::Sample> LightDome::sample(double u1, double u2, double u3) const {
  Direction w;
  if (u1 < lamp_share_) {
    const double z = 1 - kLampHeight * u2, r = std::sqrt(std::max(0.0, 1 - z * z));
    w = frame_around(*lamp_).to_world({r * std::cos(2 * kPi * u3), r * std::sin(2 * kPi * u3), z});
  } else {
    if (cumulative_.empty()) return std::nullopt;
    const double u = (u1 - lamp_share_) / (1 - lamp_share_);
    const auto at = std::min<std::size_t>(
        static_cast<std::size_t>(std::upper_bound(cumulative_.begin(), cumulative_.end(), u) -
                                 cumulative_.begin()),
        cumulative_.size() - 1);
    const auto row = static_cast<double>(at / static_cast<std::size_t>(columns_));
    const auto column = static_cast<double>(at % static_cast<std::size_t>(columns_));
    const double top = std::cos(kPi * row / rows_), bottom = std::cos(kPi * (row + 1) / rows_);
    const double y = top + (bottom - top) * u2, r = std::sqrt(std::max(0.0, 1 - y * y));
    const double l = kPi * (2 * (column + u3) / columns_ - 1);
    w = {r * std::sin(l), y, -r * std::cos(l)};
  }
  return Sample{w, radiance(w), density(w)};
}

}  // namespace lamella
