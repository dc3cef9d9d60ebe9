#include "compare/reproduce/map_sheet.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "compare/drawing/canvas.h"
#include "compare/drawing/color_bar.h"
#include "compare/drawing/color_scale.h"

namespace lamella {
namespace {

constexpr int kMargin = 14, kGap = 6, kTop = 78, kBar = 190, kLeastMap = 44, kMostMap = 160;
// Of half the longest number at an end of a bar.
constexpr int kBarMargin = 30;
constexpr Color kInk{40, 40, 40};

// Widest label of the rows.
int label_width(const MapSheet& sheet) {
  int width = 0;
  for (const MapSheet::Row& row : sheet.rows)
    width = std::max(width, text_width(row.label, Font::small));
  return width;
}

ColorScale scale_of(const MapSheet& sheet, std::size_t first) {
  std::vector<double> values;
  bool is_signed = false;
  for (std::size_t k = first; k < sheet.rows.size(); ++k) {
    if (k > first && !sheet.rows[k].same_scale) break;
    is_signed = is_signed || sheet.rows[k].is_signed;
    for (const auto& map : sheet.rows[k].maps) values.insert(values.end(), map.begin(), map.end());
  }
  return is_signed ? signed_scale(values) : magnitude_scale(values, {}, false);
}

}  // namespace

std::string draw_map_sheet(const MapSheet& sheet, PictureFormat format) {
  const std::size_t cells = static_cast<std::size_t>(sheet.side) * sheet.side;
  for (const MapSheet::Row& row : sheet.rows)
    if (row.maps.size() != sheet.columns.size() ||
        std::any_of(row.maps.begin(), row.maps.end(),
                    [&](const auto& map) { return map.size() != cells; }))
      throw std::invalid_argument("a sheet with maps of the wrong number or size");
  const int columns = static_cast<int>(sheet.columns.size());
  const int map = std::clamp(900 / std::max(columns, 1), kLeastMap, kMostMap);
  const int left = kMargin + label_width(sheet) + kGap;
  const int bar = left + columns * (map + kGap) + kBarMargin;
  const int width = bar + kBar + kBarMargin;
  const int height = kTop + static_cast<int>(sheet.rows.size()) * (map + kGap) + kMargin;
  Canvas canvas(width, height, format);
  canvas.text(kMargin, 10, sheet.title, Font::title, Align::left, kInk);
  canvas.text(kMargin, 34, sheet.subtitle, Font::small, Align::left, kInk);
  for (int c = 0; c < columns; ++c)
    canvas.text(left + c * (map + kGap) + map / 2.0, kTop - 20, sheet.columns[c], Font::small,
                Align::center, kInk);
  ColorScale scale;
  for (std::size_t r = 0; r < sheet.rows.size(); ++r) {
    const MapSheet::Row& row = sheet.rows[r];
    const int top = kTop + static_cast<int>(r) * (map + kGap);
    if (r == 0 || !row.same_scale) {
      scale = scale_of(sheet, r);
      draw_color_bar(canvas, scale, bar, top + 8, kBar, {});
    }
    canvas.text(left - kGap, top + map / 2.0 - 6, row.label, Font::small, Align::right, kInk);
    for (int c = 0; c < columns; ++c) {
      Raster raster(sheet.side, sheet.side);
      for (std::size_t k = 0; k < cells; ++k)
        if (!std::isnan(row.maps[c][k]))
          raster.set(static_cast<int>(k) % sheet.side, static_cast<int>(k) / sheet.side,
                     scale.color(row.maps[c][k]));
      canvas.paint(raster, left + c * (map + kGap), top, map, map);
    }
  }
  return canvas.bytes();
}

}  // namespace lamella
