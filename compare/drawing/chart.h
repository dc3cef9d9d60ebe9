#pragma once

#include <string>
#include <vector>

#include "compare/drawing/canvas.h"

namespace lamella {

/// One curve of a chart.
struct ChartSeries {
  std::string label;  ///< empty: shown with the series before it
  std::vector<double> x, y;
  std::vector<double> error = {};  ///< of y, drawn as bars; empty: none
  bool dots = false;               ///< dots (simulated values) instead of a line
  /// The curve's colour is that of the series before it: one quantity, drawn twice.
  bool same_color = false;
};

/// A chart of curves over one axis.
struct Chart {
  std::string title, subtitle;
  std::string x_label, y_label;
  std::vector<ChartSeries> series;
  bool from_zero = true;  ///< the y axis includes 0, unless it is logarithmic
  /// The y axis is logarithmic: values that are not positive are left out, and so are errors.
  bool log_y = false;
};

/// The file's bytes; equal charts give equal bytes. Values that are not finite are left out. Throws
/// std::invalid_argument where x, y or error have different lengths, PictureError without Cairo.
[[nodiscard]] std::string draw_chart(const Chart& chart, PictureFormat format = PictureFormat::png);

/// The colour of every series, in their order.
[[nodiscard]] std::vector<Color> series_colors(const Chart& chart);

}  // namespace lamella
