#include "compare/drawing/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "compare/drawing/canvas.h"
#include "compare/drawing/picture_text.h"

namespace lamella {
namespace {

constexpr int kWidth = 760, kHeight = 460, kLeft = 70, kTop = 58, kBottom = 46;
constexpr int kPlotWidth = 470;
constexpr Color kInk{40, 40, 40}, kFrame{120, 120, 120}, kGrid{228, 228, 228};
// Those of the pages: Okabe and Ito 2008, told apart by colour-blind eyes too, their light ones
// darker, and more.
constexpr Color kColors[] = {{0, 114, 178}, {213, 94, 0},   {0, 158, 115},  {204, 121, 167},
                             {176, 136, 0}, {59, 156, 204}, {106, 76, 147}, {140, 74, 47},
                             {95, 107, 45}, {119, 119, 119}};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  /// Not empty, and with room.
  void complete() {
    if (!(low <= high)) low = 0, high = 1;
    if (low == high) high = low + (low == 0 ? 1 : std::abs(low));
  }
  [[nodiscard]] double share(double v) const { return (v - low) / (high - low); }
};

/// A step of 1, 2 or 5 times a power of ten that gives four to ten of them.
double step_of(const Range& range) {
  const double rough = (range.high - range.low) / 6;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double s : {1.0, 2.0, 5.0})
    if (rough <= s * power) return s * power;
  return 10 * power;
}

struct Plot {
  Canvas canvas;
  Range x{}, y{};

  [[nodiscard]] double column(double v) const { return kLeft + x.share(v) * kPlotWidth; }
  [[nodiscard]] double row(double v) const {
    return kHeight - kBottom - y.share(v) * (kHeight - kBottom - kTop);
  }
};

void draw_axes(Plot& plot, const Chart& chart) {
  // Of a logarithmic axis: whole decades, unless there are fewer than two.
  const double dx = step_of(plot.x), step = step_of(plot.y);
  const double dy = chart.log_y && plot.y.high - plot.y.low > 2 ? std::max(1.0, step) : step;
  const int bottom = kHeight - kBottom;
  for (double v = std::ceil(plot.x.low / dx - 1e-9) * dx; v <= plot.x.high + 1e-9 * dx; v += dx) {
    const int at = static_cast<int>(plot.column(v));
    plot.canvas.fill(at, kTop, 1, bottom - kTop, kGrid);
    plot.canvas.text(at, bottom + 6, fmt::format("{:.6g}", std::abs(v) < 1e-9 * dx ? 0 : v),
                     Font::small, Align::center, kInk);
  }
  for (double v = std::ceil(plot.y.low / dy - 1e-9) * dy; v <= plot.y.high + 1e-9 * dy; v += dy) {
    const int at = static_cast<int>(plot.row(v));
    plot.canvas.fill(kLeft, at, kPlotWidth, 1, kGrid);
    const double value = std::abs(v) < 1e-9 * dy ? 0 : v;
    plot.canvas.text(
        kLeft - 6, at - 6,
        chart.log_y ? fmt::format("{:.3g}", std::pow(10, value)) : fmt::format("{:.6g}", value),
        Font::small, Align::right, kInk);
  }
  plot.canvas.outline(kLeft, kTop, kPlotWidth, bottom - kTop, kFrame);
  plot.canvas.text(kLeft, 12, chart.title, Font::title, Align::left, kInk);
  plot.canvas.text(kLeft, 34, chart.subtitle, Font::small, Align::left, kInk);
  plot.canvas.text(kLeft + kPlotWidth / 2, kHeight - 20, chart.x_label, Font::small, Align::center,
                   kInk);
  plot.canvas.text_upwards(8, (kTop + bottom) / 2, chart.y_label, Font::small, kInk);
}

void draw_series(Plot& plot, const ChartSeries& s, Color color) {
  for (std::size_t k = 0; k < s.x.size(); ++k) {
    if (!std::isfinite(s.x[k]) || !std::isfinite(s.y[k])) continue;
    const double x = plot.column(s.x[k]), y = plot.row(s.y[k]);
    if (!s.error.empty() && std::isfinite(s.error[k]))
      plot.canvas.line(x, plot.row(s.y[k] - s.error[k]), x, plot.row(s.y[k] + s.error[k]), 1.2,
                       color);
    if (s.dots)
      plot.canvas.ring(x, y, 0, 2.6, color);
    else if (k > 0 && std::isfinite(s.x[k - 1]) && std::isfinite(s.y[k - 1]))
      plot.canvas.line(plot.column(s.x[k - 1]), plot.row(s.y[k - 1]), x, y, 1.8, color);
  }
}

/// The chart of log10 of its values.
Chart logarithms_of(Chart chart) {
  for (ChartSeries& s : chart.series) {
    s.error.clear();
    for (double& y : s.y) y = y > 0 ? std::log10(y) : std::numeric_limits<double>::quiet_NaN();
  }
  return chart;
}

}  // namespace

std::vector<Color> series_colors(const Chart& chart) {
  std::vector<Color> colors;
  std::size_t next = 0;
  for (const ChartSeries& s : chart.series) {
    const bool again = s.same_color && !colors.empty();
    colors.push_back(again ? colors.back() : kColors[next++ % std::size(kColors)]);
  }
  return colors;
}

std::string draw_chart(const Chart& given, PictureFormat format) {
  Plot plot{.canvas = Canvas(kWidth, kHeight, format)};
  const Chart chart = given.log_y ? logarithms_of(given) : given;
  for (const ChartSeries& s : chart.series) {
    if (s.x.size() != s.y.size() || (!s.error.empty() && s.error.size() != s.x.size()))
      throw std::invalid_argument("a series of a chart with columns of different lengths");
    for (std::size_t k = 0; k < s.x.size(); ++k) {
      plot.x.include(s.x[k]);
      plot.y.include(s.error.empty() ? s.y[k] : s.y[k] + s.error[k]);
      plot.y.include(s.error.empty() ? s.y[k] : s.y[k] - s.error[k]);
    }
  }
  if (chart.from_zero && !chart.log_y) plot.y.include(0);
  plot.x.complete();
  plot.y.complete();
  plot.y.high += 0.04 * (plot.y.high - plot.y.low);
  draw_axes(plot, chart);
  const int legend = kLeft + kPlotWidth + 14;
  int at = kTop + 4, entry = at;
  const std::vector<Color> colors = series_colors(chart);
  for (std::size_t k = 0; k < chart.series.size(); ++k) {
    const ChartSeries& s = chart.series[k];
    const Color color = colors[k];
    draw_series(plot, s, color);
    // Without a label it shares the entry of the series before it.
    if (!s.label.empty()) entry = at;
    if (s.dots)
      plot.canvas.ring(legend + 9, entry + 6, 0, 2.6, color);
    else
      plot.canvas.line(legend, entry + 6, legend + 18, entry + 6, 1.8, color);
    for (const std::string& part : wrapped(s.label, Font::small, kWidth - legend - 30)) {
      plot.canvas.text(legend + 26, at, part, Font::small, Align::left, kInk);
      at += text_height(Font::small) + 2;
    }
    if (!s.label.empty()) at += 4;
  }
  return plot.canvas.bytes();
}

}  // namespace lamella
