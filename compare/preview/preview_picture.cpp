#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>

#include "compare/drawing/canvas.h"
#include "compare/drawing/color_bar.h"
#include "compare/drawing/picture_text.h"
#include "compare/preview/flip.h"
#include "compare/preview/preview.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

constexpr int kMargin = 16, kGap = 14, kTitle = 30, kLabel = 20, kScaleLabel = 170;
constexpr Color kBackground{24, 26, 30}, kText{235, 237, 242};
constexpr double kWhitePercentile = 0.99;

std::uint8_t encoded(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

// The luminance that is shown as white.
double white_of(const std::vector<const PreviewImage*>& images) {
  std::vector<double> values;
  for (const PreviewImage* image : images)
    for (std::size_t k = 0; k < image->radiance.size(); ++k)
      if (image->covered[k]) values.push_back(luminance(image->radiance[k]));
  if (values.empty()) return 1;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(
                                       kWhitePercentile * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at > 0 ? *at : 1;
}

void text(Canvas& canvas, int x, int y, const std::string& what, Font font, int width) {
  canvas.text(x, y, shortened(what, font, width), font, Align::left, kText);
}

// The label of a picture; where it is too long, what comes after its name, then its values alone.
void label(Canvas& canvas, int x, int y, const PreviewColumn& column, int width) {
  std::string what = column.told();
  for (const char* end : {", ", "="}) {
    if (shortened(what, Font::small, width) == what) break;
    const std::size_t at = what.find(end);
    if (at != std::string::npos) what.erase(0, at + std::string_view(end).size());
  }
  text(canvas, x, y, what, Font::small, width);
}

double difference_at(const PreviewImage& truth, const PreviewImage& model, std::size_t k) {
  return luminance(model.radiance[k]) - luminance(truth.radiance[k]);
}

void paint(Canvas& canvas, int left, int top, const PreviewImage& image,
           const std::function<Color(std::size_t)>& color) {
  Raster raster(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t k = static_cast<std::size_t>(y) * image.width + x;
      if (image.covered[k]) raster.set(x, y, color(k));
    }
  canvas.paint(raster, left, top, image.width, image.height);
}

void paint_picture(Canvas& canvas, int left, int top, const PreviewImage& image, double white) {
  paint(canvas, left, top, image, [&](std::size_t k) {
    const Rgb v = (1 / white) * image.radiance[k];
    return Color{encoded(v.r), encoded(v.g), encoded(v.b)};
  });
}

void paint_difference(Canvas& canvas, int left, int top, const PreviewImage& truth,
                      const PreviewImage& model, const ColorScale& scale) {
  paint(canvas, left, top, model,
        [&](std::size_t k) { return scale.color(difference_at(truth, model, k)); });
}

}  // namespace

PreviewScales scales_of(const std::vector<PreviewColumn>& columns) {
  const PreviewImage& truth = columns.front().image;
  std::vector<double> differences;
  for (const PreviewColumn& column : columns)
    for (std::size_t k = 0; k < truth.radiance.size(); ++k)
      differences.push_back(difference_at(truth, column.image, k));
  return {white_of({&truth}), signed_scale(differences)};
}

double flip_error(const PreviewImage& truth, const PreviewImage& picture) {
  const double white = white_of({&truth});
  const auto shown = [&](const PreviewImage& image) {
    std::vector<Rgb> out;
    for (std::size_t k = 0; k < image.radiance.size(); ++k)
      out.push_back(image.covered[k] ? 1 / white * image.radiance[k] : Rgb());
    return out;
  };
  const std::vector<double> errors =
      flip_errors(truth.width, truth.height, shown(truth), shown(picture));
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < errors.size(); ++k)
    if (truth.covered[k]) {
      sum += errors[k];
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

std::string picture_png(const PreviewImage& image, double white) {
  Canvas canvas(image.width, image.height);
  canvas.fill(0, 0, image.width, image.height, kBackground);
  paint_picture(canvas, 0, 0, image, white);
  return canvas.bytes();
}

std::string difference_png(const PreviewImage& truth, const PreviewImage& model,
                           const ColorScale& scale) {
  Canvas canvas(model.width, model.height);
  canvas.fill(0, 0, model.width, model.height, kBackground);
  paint_difference(canvas, 0, 0, truth, model, scale);
  return canvas.bytes();
}

std::string draw_preview(const std::string& title, const std::vector<PreviewColumn>& columns,
                         PictureFormat format) {
  Canvas::require_available();
  const PreviewImage& truth = columns.front().image;
  const int count = static_cast<int>(columns.size());
  const int width = std::max(320, 2 * kMargin + count * truth.width + (count - 1) * kGap);
  const int second = kTitle + kLabel + truth.height + kGap;
  const bool models = count > 1;
  const int height = second + (models ? kLabel + truth.height + kGap : 0) + kColorBarHeight;
  Canvas canvas(width, height, format);
  canvas.fill(0, 0, width, height, kBackground);
  text(canvas, kMargin, 8, title, Font::bold, width - 2 * kMargin);
  const PreviewScales scales = scales_of(columns);
  for (int c = 0; c < count; ++c) {
    const PreviewImage& image = columns[c].image;
    const int left = kMargin + c * (truth.width + kGap);
    label(canvas, left, kTitle, columns[c], truth.width);
    paint_picture(canvas, left, kTitle + kLabel, image, scales.white);
    if (c == 0) continue;
    text(canvas, left, second, "model \u2212 truth", Font::small, truth.width);
    paint_difference(canvas, left, second + kLabel, truth, image, scales.difference);
  }
  if (models) {
    const int bar = std::min(width - kScaleLabel - 3 * kMargin, 256),
              top = height - kColorBarHeight - 2;
    canvas.fill(0, top - 4, width, height - top + 4, Color{255, 255, 255});
    draw_color_bar(canvas, scales.difference, kMargin + kScaleLabel, top, bar, {});
    canvas.text(kMargin, top, "luminance, model \u2212 truth", Font::small, Align::left,
                Color{0, 0, 0});
  }
  return canvas.bytes();
}

std::string draw_gallery(const std::string& title, const std::vector<PreviewColumn>& columns,
                         std::optional<double> white, PictureFormat format) {
  Canvas::require_available();
  const PreviewImage& first = columns.front().image;
  const int count = static_cast<int>(columns.size());
  const int width = std::max(320, 2 * kMargin + count * first.width + (count - 1) * kGap);
  Canvas canvas(width, kTitle + kLabel + first.height + kMargin, format);
  canvas.fill(0, 0, width, kTitle + kLabel + first.height + kMargin, kBackground);
  text(canvas, kMargin, 8, title, Font::bold, width - 2 * kMargin);
  std::vector<const PreviewImage*> images;
  for (const PreviewColumn& column : columns) images.push_back(&column.image);
  const double shown = white ? *white : white_of(images);
  for (int c = 0; c < count; ++c) {
    const int left = kMargin + c * (first.width + kGap);
    label(canvas, left, kTitle, columns[c], first.width);
    paint_picture(canvas, left, kTitle + kLabel, columns[c].image, shown);
  }
  return canvas.bytes();
}

}  // namespace lamella
