#include "compare/reproduce/lobe_matrix.h"

#include <cmath>

#include "compare/drawing/canvas.h"
#include "compare/drawing/color_bar.h"
#include "compare/drawing/color_scale.h"

namespace lamella {
namespace {

constexpr int kPanel = 256, kMargin = 20, kGap = 36, kHead = 72, kLabel = 18;
constexpr Color kInk{30, 34, 40};

// The value at (incident direction, outgoing cell of absolute azimuth) of a side.
double value_at(const LobeMatrix& matrix, const LobeMatrix::Panel& panel, int incident, int side,
                int cell) {
  const CellGrid& grid = matrix.grid;
  const int columns = grid.columns();
  const int turned = (cell % columns - incident % columns + columns) % columns;
  const int relative = cell / columns * columns + turned;
  return panel.values[(static_cast<std::size_t>(incident) * 2 + side) * grid.cells() + relative];
}

// The panels' values of one side, of differences or not.
std::vector<double> values_of(const LobeMatrix& matrix, int side, bool difference) {
  std::vector<double> values;
  const auto cells = static_cast<std::size_t>(matrix.grid.cells());
  for (const LobeMatrix::Panel& panel : matrix.panels) {
    if (panel.difference != difference) continue;
    for (std::size_t k = 0; k < panel.values.size(); ++k)
      if (k / cells % 2 == static_cast<std::size_t>(side)) values.push_back(panel.values[k]);
  }
  return values;
}

}  // namespace

std::vector<MatrixDirection> matrix_directions(const CellGrid& grid) {
  std::vector<MatrixDirection> directions;
  for (int row = 0; row < grid.rows(); ++row)
    for (int column = 0; column < grid.columns(); ++column)
      directions.push_back({std::sqrt(1 - (row + 0.5) / grid.mu_cells), grid.edge_phi(column)});
  return directions;
}

std::string draw_lobe_matrix(const LobeMatrix& matrix, PictureFormat format) {
  const int count = static_cast<int>(matrix.panels.size()), cells = matrix.grid.cells();
  const int width = 2 * kMargin + count * kPanel + (count - 1) * kGap;
  const int row = kLabel + kPanel + kGap / 2 + kColorBarHeight + kGap / 2;
  const int height = kHead + 2 * row + kMargin / 2;
  Canvas canvas(width, height, format);
  canvas.text(kMargin, 14, matrix.title, Font::title, Align::left, kInk);
  canvas.text(kMargin, 38, matrix.subtitle, Font::small, Align::left, kInk);
  for (const int side : {0, 1}) {
    const ColorScale magnitude = magnitude_scale(values_of(matrix, side, false), {}, false);
    const ColorScale difference = signed_scale(values_of(matrix, side, true));
    for (int k = 0; k < count; ++k) {
      const LobeMatrix::Panel& panel = matrix.panels[k];
      const ColorScale& scale = panel.difference ? difference : magnitude;
      const int left = kMargin + k * (kPanel + kGap), top = kHead + side * row;
      canvas.text(left, top - 4, panel.label + (side == 0 ? ", reflected" : ", transmitted"),
                  Font::small, Align::left, kInk);
      Raster raster(cells, cells);
      for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x)
          raster.set(x, y, scale.color(value_at(matrix, panel, y, side, x)));
      canvas.paint(raster, left, top + kLabel, kPanel, kPanel);
      draw_color_bar(canvas, scale, left, top + kLabel + kPanel + kGap / 2, kPanel, {});
    }
  }
  return canvas.bytes();
}

}  // namespace lamella
