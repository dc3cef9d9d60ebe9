#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/canvas.h"
#include "compare/color_bar.h"
#include "compare/color_scale.h"
#include "compare/preview.h"

namespace lamella {
namespace {

constexpr int kMargin = 16, kGap = 14, kTitle = 30, kLabel = 20, kScaleLabel = 170;
constexpr Color kBackground{24, 26, 30}, kText{235, 237, 242};
constexpr double kWhitePercentile = 0.99;

double luminance(Rgb c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; }

std::uint8_t encoded(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

// The luminance that is shown as white.
double white_of(const PreviewImage& truth) {
  std::vector<double> values;
  for (std::size_t k = 0; k < truth.radiance.size(); ++k)
    if (truth.covered[k]) values.push_back(luminance(truth.radiance[k]));
  if (values.empty()) return 1;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(
                                       kWhitePercentile * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at > 0 ? *at : 1;
}

void text(Canvas& canvas, int x, int y, const std::string& what, Font font, int width) {
  canvas.text(x, y, shortened(what, font, width), font, Align::left, kText);
}

}  // namespace

std::string draw_preview(const std::string& title, const std::vector<PreviewColumn>& columns) {
  const PreviewImage& truth = columns.front().image;
  const int count = static_cast<int>(columns.size());
  const int width = std::max(320, 2 * kMargin + count * truth.width + (count - 1) * kGap);
  const int second = kTitle + kLabel + truth.height + kGap;
  const bool models = count > 1;
  const int height = second + (models ? kLabel + truth.height + kGap : 0) + kColorBarHeight;
  Canvas canvas(width, height);
  canvas.fill(0, 0, width, height, kBackground);
  text(canvas, kMargin, 8, title, Font::bold, width - 2 * kMargin);
  const double white = white_of(truth);
  std::vector<double> differences;
  for (const PreviewColumn& column : columns)
    for (std::size_t k = 0; k < truth.radiance.size(); ++k)
      differences.push_back(luminance(column.image.radiance[k]) - luminance(truth.radiance[k]));
  const ColorScale scale = signed_scale(differences);
  for (int c = 0; c < count; ++c) {
    const PreviewImage& image = columns[c].image;
    const int left = kMargin + c * (truth.width + kGap);
    text(canvas, left, kTitle, columns[c].name, Font::small, truth.width);
    if (c > 0) text(canvas, left, second, "model - truth", Font::small, truth.width);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const std::size_t k = static_cast<std::size_t>(y) * image.width + x;
        if (!image.covered[k]) continue;
        const Rgb v = (1 / white) * image.radiance[k];
        canvas.pixel(left + x, kTitle + kLabel + y, {encoded(v.r), encoded(v.g), encoded(v.b)});
        if (c > 0)
          canvas.pixel(
              left + x, second + kLabel + y,
              scale.color(differences[static_cast<std::size_t>(c) * image.radiance.size() + k]));
      }
  }
  if (models) {
    const int bar = std::min(width - kScaleLabel - 3 * kMargin, 256),
              top = height - kColorBarHeight - 2;
    canvas.fill(0, top - 4, width, height - top + 4, Color{255, 255, 255});
    draw_color_bar(canvas, scale, kMargin + kScaleLabel, top, bar, false);
    canvas.text(kMargin, top, "luminance, model - truth", Font::small, Align::left, Color{0, 0, 0});
  }
  return canvas.png();
}

}  // namespace lamella
