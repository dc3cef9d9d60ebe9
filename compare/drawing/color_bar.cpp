#include "compare/drawing/color_bar.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "compare/drawing/picture_text.h"

namespace lamella {
namespace {

constexpr int kBarHeight = 14;
constexpr Color kText{32, 32, 32}, kLine{110, 110, 110};

/// Every how many ticks a label fits, counted from the one of 0 (or the first): the fewest, but
/// rather more if the ends get theirs and three are left.
std::size_t label_stride(const std::vector<ColorScale::Tick>& ticks, std::size_t anchor,
                         int width) {
  const auto fits = [&](std::size_t stride) {
    double end = -width;
    for (std::size_t i = anchor % stride; i < ticks.size(); i += stride) {
      const double middle = ticks[i].position * width;
      const double half = text_width(ticks[i].label, Font::small) / 2.0;
      if (middle - half < end + 9) return false;
      end = middle + half;
    }
    return true;
  };
  std::size_t first = 0;
  for (std::size_t stride = 1; stride < ticks.size(); ++stride) {
    if (!fits(stride)) continue;
    if (first == 0) first = stride;
    const std::size_t last = ticks.size() - 1;
    if (anchor % stride == 0 && (last - anchor) % stride == 0 && 2 * stride <= last) return stride;
  }
  return first == 0 ? std::max<std::size_t>(1, ticks.size()) : first;
}

void draw_bar_labels(Canvas& canvas, const ColorScale& scale, int left, int top, int width) {
  const auto ticks = scale.ticks();
  std::size_t anchor = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i)
    if (ticks[i].label == "0") anchor = i;
  const std::size_t stride = label_stride(ticks, anchor, width);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const int x = left + static_cast<int>(std::lround(ticks[i].position * (width - 1)));
    canvas.fill(x, top, 1, 4, kLine);
    if (i % stride == anchor % stride)
      canvas.text(x + 1, top + 5, ticks[i].label, Font::small, Align::center, kText);
  }
}

}  // namespace

void draw_color_bar(Canvas& canvas, const ColorScale& scale, int left, int top, int width,
                    OpenEnds open) {
  for (int x = 0; x < width; ++x)
    canvas.fill(left + x, top, 1, kBarHeight, scale.color_at((x + 0.5) / width));
  canvas.outline(left - 1, top - 1, width + 2, kBarHeight + 2, kLine);
  for (int i = 0; i < kBarHeight / 2 + 1; ++i) {
    const int y = top - 1 + i, height = kBarHeight + 2 - 2 * i;
    if (open.low) canvas.fill(left - 2 - i, y, 1, height, scale.color_at(0));
    if (open.high) canvas.fill(left + width + 1 + i, y, 1, height, scale.color_at(1));
  }
  draw_bar_labels(canvas, scale, left, top + kBarHeight + 1, width);
}

}  // namespace lamella
