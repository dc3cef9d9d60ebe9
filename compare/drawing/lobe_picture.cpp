#include "compare/drawing/lobe_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>

#include "compare/drawing/canvas.h"
#include "compare/drawing/color_bar.h"
#include "compare/drawing/color_scale.h"
#include "compare/drawing/picture_text.h"

namespace lamella {
namespace {

using Map = std::span<const double>;
constexpr int kPanel = PictureLayout::kPanel, kRectangle = PictureLayout::kRectangle;
constexpr Color kBlack{0, 0, 0}, kWhite{255, 255, 255}, kText{32, 32, 32}, kSoftText{96, 96, 96},
    kLine{110, 110, 110};
constexpr double kZLimit = 4;
constexpr int kLineHeight = 16, kTop = 14, kBottom = 14;
// From the bottom of the rectangles to the colour bars.
constexpr int kAxisHeight = 48;

struct Panel {
  Map map;
  std::string heading;
};

/// Panels side by side that share a colour scale, and what is written below it.
struct Group {
  ColorScale scale;
  std::vector<Panel> panels{};
  std::vector<std::string> notes{};
  OpenEnds open{};
  bool magnitudes = false;  // signs are left out

  [[nodiscard]] int width() const {
    const int n = static_cast<int>(panels.size());
    return n * kPanel + (n - 1) * PictureLayout::kGap;
  }
};

template <class Test>
int count_cells(Map map, const Test& test) {
  return static_cast<int>(std::count_if(map.begin(), map.end(), test));
}

void add_notes(Group& group, const std::string& note) {
  for (std::string& line : wrapped(note, Font::small, group.width() + PictureLayout::kGap / 2))
    group.notes.push_back(std::move(line));
}

std::string cells_text(int count, std::size_t of) {
  return fmt::format("{} of {} cells", count, of);
}

Group magnitude_group(const LobePicture& picture) {
  Group group{.scale = magnitude_scale(picture.truth, picture.model, picture.logarithmic)};
  if (!picture.truth.empty()) group.panels.push_back({picture.truth, picture.truth_label});
  if (!picture.model.empty()) group.panels.push_back({picture.model, picture.model_label});
  const bool logarithmic = group.scale.kind == ColorScale::Kind::logarithmic;
  add_notes(group, fmt::format("f [sr\u207b\u00b9], {}{}", logarithmic ? "logarithmic" : "linear",
                               group.panels.size() > 1 ? ", one scale for both" : ""));
  for (const Panel& panel : group.panels) {
    const double low = group.scale.low;
    const int below = count_cells(panel.map, [&](double v) { return v < low; });
    if (below > 0 && logarithmic)
      add_notes(group, fmt::format("{}: {} below {:.3g}, shown as that", panel.heading,
                                   cells_text(below, panel.map.size()), low));
    const int negative = count_cells(panel.map, [](double v) { return v < 0; });
    if (negative > 0 && !logarithmic)
      add_notes(group, fmt::format("{}: {} negative", panel.heading,
                                   cells_text(negative, panel.map.size())));
    const int infinite = count_cells(panel.map, [](double v) { return std::isinf(v); });
    if (infinite > 0)
      add_notes(group, fmt::format("{}: {} infinite", panel.heading,
                                   cells_text(infinite, panel.map.size())));
  }
  return group;
}

Group difference_group(Map map) {
  Group group{.scale = signed_scale(map), .panels = {{map, "model \u2212 truth"}}};
  add_notes(group, "difference [sr\u207b\u00b9]");
  const int infinite = count_cells(map, [](double v) { return std::isinf(v); });
  if (infinite > 0) add_notes(group, cells_text(infinite, map.size()) + " infinite");
  return group;
}

Group z_group(Map map) {
  Group group{.scale = fixed_signed_scale(kZLimit, 2), .panels = {{map, "z"}}};
  group.open = {count_cells(map, [](double v) { return v < -kZLimit; }) > 0,
                count_cells(map, [](double v) { return v > kZLimit; }) > 0};
  const int beyond = count_cells(map, [](double v) { return std::fabs(v) > kZLimit; });
  add_notes(group, "difference / standard error");
  add_notes(group, fmt::format("|z| > {}: {}", kZLimit, cells_text(beyond, map.size())));
  return group;
}

/// Of a bounded truth, whose bounds are so small that z would be far beyond any fixed end.
Group bound_group(Map map) {
  Group group{.scale = ratio_scale(map), .panels = {{map, "error over bound"}}, .magnitudes = true};
  group.open = {count_cells(map, [&](double v) { return std::fabs(v) < group.scale.low; }) > 0,
                count_cells(map, [&](double v) { return std::fabs(v) > group.scale.high; }) > 0};
  const int beyond = count_cells(map, [](double v) { return std::fabs(v) > 1; });
  add_notes(group, "|difference| / error bound, logarithmic");
  add_notes(group, fmt::format("beyond the bound: {}", cells_text(beyond, map.size())));
  return group;
}

std::vector<Group> groups_of(const LobePicture& picture) {
  const Map maps[] = {picture.truth, picture.model, picture.difference, picture.z};
  bool any = false;
  for (const Map map : maps) {
    if (!map.empty() && static_cast<int>(map.size()) != picture.grid.cells())
      throw std::invalid_argument(fmt::format("a map of {} values on a grid of {} cells",
                                              map.size(), picture.grid.cells()));
    any = any || !map.empty();
  }
  if (!any) throw std::invalid_argument("a picture of a lobe needs at least one map");
  std::vector<Group> groups;
  if (!picture.truth.empty() || !picture.model.empty()) groups.push_back(magnitude_group(picture));
  if (!picture.difference.empty()) groups.push_back(difference_group(picture.difference));
  if (!picture.z.empty())
    groups.push_back(picture.bounded ? bound_group(picture.z) : z_group(picture.z));
  return groups;
}

/// What stands around the panels, broken into lines.
struct Page {
  PictureLayout layout;
  std::vector<std::string> title, subtitle, convention;
  int notes_top = 0, legend_top = 0;
  bool has_empty_cells = false;
};

Page page_of(const LobePicture& picture, const std::vector<Group>& groups) {
  Page page;
  std::size_t notes = 0;
  for (const Group& group : groups) {
    page.layout.panels += static_cast<int>(group.panels.size());
    notes = std::max(notes, group.notes.size());
    for (const Panel& panel : group.panels)
      if (count_cells(panel.map, [](double v) { return std::isnan(v); }) > 0)
        page.has_empty_cells = true;
  }
  PictureLayout& layout = page.layout;
  layout.width =
      PictureLayout::panel_left(layout.panels) - PictureLayout::kGap + PictureLayout::kRight;
  const int text = layout.width - 2 * 20;
  page.title = wrapped(picture.title, Font::title, text);
  page.subtitle = wrapped(picture.subtitle, Font::small, text);
  page.convention = wrapped(
      "Discs: radius sin \u03b8_o, \u03c6_o counter-clockwise from the side of w_i. "
      "Equal cells have equal area, which is their projected solid angle.",
      Font::small, text);
  const int lines = static_cast<int>(page.title.size() + page.subtitle.size());
  layout.disc_top = kTop + lines * kLineHeight + 52;
  layout.rectangle_top = layout.disc_top + kPanel + 34;
  page.notes_top = layout.rectangle_top + kRectangle + kAxisHeight + kColorBarHeight;
  page.legend_top = page.notes_top + static_cast<int>(notes) * kLineHeight + 14;
  layout.height =
      page.legend_top + (1 + static_cast<int>(page.convention.size())) * kLineHeight + kBottom;
  return page;
}

/// Colour of a cell without a value at a place: it can't be taken for one of a scale.
Color hatch(double x, double y) {
  return std::fmod(x + y, 6) < 2 ? Color{150, 150, 150} : Color{214, 214, 214};
}

/// The cells under the pixels of a disc, kSide x kSide samples each; -1 outside. The same for all
/// panels.
class DiscCells {
 public:
  static constexpr int kSide = 3, kSamples = kSide * kSide;

  /// `scale`: pixels per unit of length.
  DiscCells(const CellGrid& grid, int scale) : size_(kPanel * scale) {
    cells_.reserve(static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_) * kSamples);
    for (int y = 0; y < size_; ++y)
      for (int x = 0; x < size_; ++x)
        for (int s = 0; s < kSamples; ++s) {
          const int across = s % kSide, down = s / kSide;
          const double u = 2 * (x + (across + 0.5) / kSide) / size_ - 1;
          const double v = 1 - 2 * (y + (down + 0.5) / kSide) / size_;
          const double sine2 = u * u + v * v, phi = std::atan2(v, u);
          cells_.push_back(sine2 > 1 ? -1 : grid.cell(1 - sine2, phi < 0 ? phi + 2 * kPi : phi));
        }
  }

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] std::span<const int> samples(int x, int y) const {
    const std::size_t pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(x);
    return std::span(cells_).subspan(pixel * kSamples, kSamples);
  }

 private:
  int size_;
  std::vector<int> cells_;
};

/// A map with its colours looked up once; none for nan.
class Painter {
 public:
  Painter(const CellGrid& grid, Map map, const Group& group) : grid_(grid) {
    colors_.reserve(map.size());
    for (const double v : map)
      colors_.push_back(
          std::isnan(v) ? std::nullopt
                        : std::optional(group.scale.color(group.magnitudes ? std::fabs(v) : v)));
  }

  /// Each pixel is the mean of what it covers of the disc; outside stays as it is.
  void disc(Canvas& canvas, const DiscCells& cells, int left, int top) const {
    const int size = cells.size();
    const double step = 1.0 / canvas.raster_scale();
    Raster raster(size, size);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        int r = 0, g = 0, b = 0, count = 0;
        for (const int cell : cells.samples(x, y)) {
          if (cell < 0) continue;
          const Color c = at(cell, left + x * step, top + y * step);
          r += c.r, g += c.g, b += c.b, ++count;
        }
        if (count == 0) continue;
        const auto mean = [&](int sum) { return static_cast<std::uint8_t>(sum / count); };
        raster.set(x, y, {mean(r), mean(g), mean(b)},
                   static_cast<double>(count) / DiscCells::kSamples);
      }
    canvas.paint(raster, left, top, kPanel, kPanel);
  }

  void rectangle(Canvas& canvas, int left, int top) const {
    const double phi_range = grid_.folded ? kPi : 2 * kPi;
    const int scale = canvas.raster_scale(), width = kPanel * scale, height = kRectangle * scale;
    Raster raster(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const int cell = grid_.cell(1 - (y + 0.5) / height, (x + 0.5) / width * phi_range);
        raster.set(
            x, y,
            at(cell, left + static_cast<double>(x) / scale, top + static_cast<double>(y) / scale));
      }
    canvas.paint(raster, left, top, kPanel, kRectangle);
  }

 private:
  [[nodiscard]] Color at(int cell, double x, double y) const {
    const auto& color = colors_[static_cast<std::size_t>(cell)];
    return color ? *color : hatch(x, y);
  }

  const CellGrid& grid_;
  std::vector<std::optional<Color>> colors_;
};

/// A ring for w_i, a cross for -w_i, dark on light so that they show on any colour.
void draw_mark(Canvas& canvas, double x, double y, bool transmitted) {
  if (transmitted) {
    canvas.cross(x, y, 6, 5, kWhite);
    canvas.cross(x, y, 5, 2.4, kBlack);
  } else {
    canvas.ring(x, y, 2.5, 7, kWhite);
    canvas.ring(x, y, 3.7, 5.8, kBlack);
  }
}

void draw_disc_frame(Canvas& canvas, const LobePicture& picture, int left, int top) {
  const double radius = kPanel / 2.0, x = left + radius, y = top + radius;
  canvas.ring(x, y, radius - 0.5, radius + 0.7, kLine);
  const int middle = top + kPanel / 2 - text_height(Font::small) / 2;
  canvas.text(left + kPanel + 10, middle, "0\u00b0", Font::small, Align::left, kSoftText);
  canvas.text(left - 6, middle, "180\u00b0", Font::small, Align::right, kSoftText);
  canvas.text(left + kPanel / 2 + 3, top - 16, "90\u00b0", Font::small, Align::center, kSoftText);
  canvas.text(left + kPanel / 2 + 3, top + kPanel + 4, "270\u00b0", Font::small, Align::center,
              kSoftText);
  const double sine = std::sqrt(std::fmax(0, 1 - picture.mu_i * picture.mu_i));
  draw_mark(canvas, x + (picture.transmitted ? -sine : sine) * radius, y, picture.transmitted);
}

void draw_rectangle_frame(Canvas& canvas, const LobePicture& picture, int left, int top,
                          bool first) {
  canvas.outline(left - 1, top - 1, kPanel + 2, kRectangle + 2, kLine);
  for (int i = 0; i <= 4; ++i) {
    const int x = left + i * kPanel / 4 - (i == 4 ? 1 : 0);
    canvas.fill(x, top + kRectangle + 1, 1, 4, kLine);
    canvas.text(x + 3, top + kRectangle + 8,
                fmt::format("{}\u00b0", i * (picture.grid.folded ? 45 : 90)), Font::small,
                Align::center, kSoftText);
  }
  canvas.text(
      left + kPanel / 2, top + kRectangle + 22,
      picture.grid.folded ? "\u03c6_o (folded: each stands for \u2212\u03c6_o too)" : "\u03c6_o",
      Font::small, Align::center, kSoftText);
  constexpr struct {
    int theta;
    double sine2;
  } kTicks[] = {{0, 0}, {30, 0.25}, {45, 0.5}, {60, 0.75}, {90, 1}};
  for (const auto& tick : kTicks) {
    const int y = top + static_cast<int>(std::lround(tick.sine2 * (kRectangle - 1)));
    canvas.fill(left - 5, y, 4, 1, kLine);
    if (first)
      canvas.text(left - 9, y - 6, fmt::format("{}\u00b0", tick.theta), Font::small, Align::right,
                  kSoftText);
  }
  if (first)
    canvas.text_upwards(left - 50, top + kRectangle / 2, "\u03b8_o, even in \u03bc_o\u00b2",
                        Font::small, kSoftText);
  const double sine2 = 1 - picture.mu_i * picture.mu_i;
  // -w_i is at phi = 180 degrees: half way, or the end of a folded grid.
  const double x = !picture.transmitted ? 0 : picture.grid.folded ? kPanel : kPanel / 2.0;
  draw_mark(canvas, left + x, top + std::clamp(sine2, 0.0, 1.0) * kRectangle, picture.transmitted);
}

void draw_legend(Canvas& canvas, const LobePicture& picture, const Page& page) {
  int x = 20;
  const int y = page.legend_top;
  draw_mark(canvas, x + 7, y + 7, picture.transmitted);
  const std::string mark = picture.transmitted ? "\u2212w_i (straight through)" : "w_i";
  canvas.text(x + 20, y, mark, Font::small, Align::left, kText);
  x += 20 + text_width(mark, Font::small) + 24;
  if (page.has_empty_cells) {
    constexpr int kWidth = 22, kHeight = 13;
    const int scale = canvas.raster_scale();
    Raster raster(kWidth * scale, kHeight * scale);
    for (int j = 0; j < raster.height(); ++j)
      for (int i = 0; i < raster.width(); ++i)
        raster.set(i, j,
                   hatch(x + static_cast<double>(i) / scale, y + static_cast<double>(j) / scale));
    canvas.paint(raster, x, y, kWidth, kHeight);
    canvas.outline(x - 1, y - 1, 24, 15, kLine);
    canvas.text(x + 29, y, "cell without a value", Font::small, Align::left, kText);
  }
  for (std::size_t i = 0; i < page.convention.size(); ++i)
    canvas.text(20, y + 4 + static_cast<int>(i + 1) * kLineHeight, page.convention[i], Font::small,
                Align::left, kSoftText);
}

}  // namespace

PictureLayout layout_of(const LobePicture& picture) {
  return page_of(picture, groups_of(picture)).layout;
}

std::string draw_lobe(const LobePicture& picture, PictureFormat format) {
  Canvas::require_available();
  const std::vector<Group> groups = groups_of(picture);
  const Page page = page_of(picture, groups);
  const PictureLayout& layout = page.layout;
  Canvas canvas(layout.width, layout.height, format);
  const DiscCells cells(picture.grid, canvas.raster_scale());
  int y = kTop;
  for (const std::string& line : page.title) {
    canvas.text(20, y, line, Font::title, Align::left, kText);
    y += kLineHeight;
  }
  for (const std::string& line : page.subtitle) {
    canvas.text(20, y + 4, line, Font::small, Align::left, kSoftText);
    y += kLineHeight;
  }
  int index = 0;
  for (const Group& group : groups) {
    const int bar_left = PictureLayout::panel_left(index);
    for (const Panel& panel : group.panels) {
      const int left = PictureLayout::panel_left(index);
      const Painter painter(picture.grid, panel.map, group);
      canvas.text(left + kPanel / 2, layout.disc_top - 36,
                  shortened(panel.heading, Font::bold, kPanel + PictureLayout::kGap / 2),
                  Font::bold, Align::center, kText);
      painter.disc(canvas, cells, left, layout.disc_top);
      draw_disc_frame(canvas, picture, left, layout.disc_top);
      painter.rectangle(canvas, left, layout.rectangle_top);
      draw_rectangle_frame(canvas, picture, left, layout.rectangle_top, index == 0);
      ++index;
    }
    draw_color_bar(canvas, group.scale, bar_left, layout.rectangle_top + kRectangle + kAxisHeight,
                   group.width(), group.open);
    for (std::size_t i = 0; i < group.notes.size(); ++i)
      canvas.text(bar_left + group.width() / 2, page.notes_top + static_cast<int>(i) * kLineHeight,
                  group.notes[i], Font::small, Align::center, i == 0 ? kText : kSoftText);
  }
  draw_legend(canvas, picture, page);
  return canvas.bytes();
}

}  // namespace lamella
