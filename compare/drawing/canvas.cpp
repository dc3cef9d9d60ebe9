#include "compare/drawing/canvas.h"

#include <gd.h>
#include <gdfontg.h>
#include <gdfontmb.h>
#include <gdfonts.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

namespace lamella {
namespace {

int packed(Color c) { return gdTrueColor(c.r, c.g, c.b); }

gdFontPtr font_of(Font font) {
  switch (font) {
    case Font::bold:
      return gdFontGetMediumBold();
    case Font::title:
      return gdFontGetGiant();
    case Font::small:
      break;
  }
  return gdFontGetSmall();
}

/// UTF-8 to the fonts' ISO 8859-2.
std::string encoded(std::string_view utf8) {
  std::string out;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto c = static_cast<unsigned char>(utf8[i]);
    if (c < 0x80) {
      out += c < 0x20 || c == 0x7f ? ' ' : static_cast<char>(c);
    } else if (c >= 0xc0) {
      const bool degree = utf8.substr(i, 2) == "\xc2\xb0";
      out += degree ? '\xb0' : '?';
    }
  }
  return out;
}

/// Share of a pixel's samples that lie inside a shape.
template <class Inside>
double coverage_of(int x, int y, const Inside& inside) {
  constexpr int kSide = 4;
  int count = 0;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) count += inside(x + (i + 0.5) / kSide, y + (j + 0.5) / kSide);
  return static_cast<double>(count) / (kSide * kSide);
}

unsigned char* text_bytes(std::string& s) { return reinterpret_cast<unsigned char*>(s.data()); }

}  // namespace

void Canvas::Destroy::operator()(gdImageStruct* image) const { gdImageDestroy(image); }

Canvas::Canvas(int width, int height) : image_(gdImageCreateTrueColor(width, height)) {
  if (!image_) throw std::bad_alloc();
  fill(0, 0, width, height, {255, 255, 255});
}

void Canvas::fill(int x, int y, int width, int height, Color color) {
  gdImageFilledRectangle(image_.get(), x, y, x + width - 1, y + height - 1, packed(color));
}

void Canvas::outline(int x, int y, int width, int height, Color color) {
  gdImageRectangle(image_.get(), x, y, x + width - 1, y + height - 1, packed(color));
}

void Canvas::pixel(int x, int y, Color color) {
  gdImageSetPixel(image_.get(), x, y, packed(color));
}

void Canvas::blend(int x, int y, Color color, double coverage) {
  if (!(coverage > 0) || !gdImageBoundsSafe(image_.get(), x, y)) return;
  const int old = gdImageGetTrueColorPixel(image_.get(), x, y);
  const auto mix = [&](int from, int to) {
    return static_cast<std::uint8_t>(std::lround(from + coverage * (to - from)));
  };
  pixel(x, y,
        {mix(gdTrueColorGetRed(old), color.r), mix(gdTrueColorGetGreen(old), color.g),
         mix(gdTrueColorGetBlue(old), color.b)});
}

void Canvas::ring(double x, double y, double inner, double outer, Color color, double opacity) {
  const auto inside = [&](double px, double py) {
    const double r = std::hypot(px - x, py - y);
    return r <= outer && r >= inner;
  };
  for (int j = static_cast<int>(y - outer) - 1; j <= y + outer + 1; ++j)
    for (int i = static_cast<int>(x - outer) - 1; i <= x + outer + 1; ++i) {
      const double dx = i + 0.5 - x, dy = j + 0.5 - y, r2 = dx * dx + dy * dy;
      // No corner of a pixel is further from its centre than this.
      constexpr double kReach = 0.75;
      const double near = std::fmax(0, inner - kReach), far = outer + kReach;
      if (r2 >= near * near && r2 <= far * far)
        blend(i, j, color, opacity * coverage_of(i, j, inside));
    }
}

void Canvas::cross(double x, double y, double arm, double stroke, Color color) {
  const auto inside = [&](double px, double py) {
    const double u = std::fabs(px - x + (py - y)), v = std::fabs(px - x - (py - y));
    return std::min(u, v) <= stroke / std::sqrt(2.0) && std::max(u, v) <= 2 * arm;
  };
  for (int j = static_cast<int>(y - arm) - 2; j <= y + arm + 2; ++j)
    for (int i = static_cast<int>(x - arm) - 2; i <= x + arm + 2; ++i)
      blend(i, j, color, coverage_of(i, j, inside));
}

void Canvas::text(int x, int y, std::string_view utf8, Font font, Align align, Color color) {
  std::string bytes = encoded(utf8);
  const int width = text_width(utf8, font);
  if (align == Align::center) x -= width / 2;
  if (align == Align::right) x -= width;
  gdImageString(image_.get(), font_of(font), x, y, text_bytes(bytes), packed(color));
}

void Canvas::text_upwards(int x, int y, std::string_view utf8, Font font, Color color) {
  std::string bytes = encoded(utf8);
  gdImageStringUp(image_.get(), font_of(font), x, y + text_width(utf8, font) / 2, text_bytes(bytes),
                  packed(color));
}

std::string Canvas::png() const {
  int size = 0;
  const std::unique_ptr<void, void (*)(void*)> data(gdImagePngPtrEx(image_.get(), &size, 6),
                                                    gdFree);
  if (!data) throw std::runtime_error("the picture could not be encoded as PNG");
  return {static_cast<const char*>(data.get()), static_cast<std::size_t>(size)};
}

int text_width(std::string_view utf8, Font font) {
  return static_cast<int>(encoded(utf8).size()) * font_of(font)->w;
}

int text_height(Font font) { return font_of(font)->h; }

std::vector<std::string> wrapped(std::string_view utf8, Font font, int width) {
  std::vector<std::string> lines;
  std::string line;
  while (!utf8.empty()) {
    const std::size_t end = std::min(utf8.find(' '), utf8.size());
    const std::string word(utf8.substr(0, end));
    utf8.remove_prefix(std::min(end + 1, utf8.size()));
    std::string longer = line;
    if (!line.empty()) longer += ' ';
    longer += word;
    if (text_width(longer, font) <= width) {
      line = longer;
      continue;
    }
    if (!line.empty()) lines.push_back(line);
    line = shortened(word, font, width);
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

std::string shortened(std::string_view utf8, Font font, int width) {
  std::string text(utf8);
  if (text_width(text, font) <= width) return text;
  // A character has at most four bytes: the rest can't fit.
  text.resize(std::min(text.size(), static_cast<std::size_t>(4 * width / font_of(font)->w)));
  do {
    text.pop_back();
    // Not in the middle of a character.
    while (!text.empty() && (static_cast<unsigned char>(utf8[text.size()]) & 0xc0) == 0x80)
      text.pop_back();
  } while (!text.empty() && text_width(text + "...", font) > width);
  return text + "...";
}

}  // namespace lamella
