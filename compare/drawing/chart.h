#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lamella {

/// One curve of a chart.
struct ChartSeries {
  std::string label;
  std::vector<double> x, y;
  std::vector<double> error = {};  ///< of y, drawn as bars; empty: none
  bool dots = false;               ///< dots (what was simulated) instead of a line
};

/// A chart of curves over one axis, linear in both.
struct Chart {
  std::string title, subtitle;
  std::string x_label, y_label;
  std::vector<ChartSeries> series;
  bool from_zero = true;  ///< the y axis includes 0
};

/// PNG bytes; equal charts give equal bytes. Values that are not finite are left out. Throws
/// std::invalid_argument where x, y or error have different lengths.
[[nodiscard]] std::string draw_chart(const Chart& chart);

/// draw_chart to a file. Throws OutputError.
void write_chart(const std::filesystem::path& path, const Chart& chart);

}  // namespace lamella
