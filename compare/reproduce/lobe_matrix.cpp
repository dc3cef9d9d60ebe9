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
  const int height = kHead + 2 * (kPanel + kLabel + kGap) + kColorBarHeight + kMargin;
  Canvas canvas(width, height, format);
  canvas.text(kMargin, 14, matrix.title, Font::title, Align::left, kInk);
  canvas.text(kMargin, 38, matrix.subtitle, Font::small, Align::left, kInk);
  std::vector<double> magnitudes, differences;
  for (const LobeMatrix::Panel& panel : matrix.panels) {
    std::vector<double>& to = panel.difference ? differences : magnitudes;
    to.insert(to.end(), panel.values.begin(), panel.values.end());
  }
  const ColorScale magnitude = magnitude_scale(magnitudes, {}, false);
  const ColorScale difference = signed_scale(differences);
  for (int k = 0; k < count; ++k) {
    const LobeMatrix::Panel& panel = matrix.panels[k];
    const ColorScale& scale = panel.difference ? difference : magnitude;
    const int left = kMargin + k * (kPanel + kGap);
    for (const int side : {0, 1}) {
      const int top = kHead + side * (kPanel + kLabel + kGap);
      canvas.text(left, top - 4, panel.label + (side == 0 ? ", reflected" : ", transmitted"),
                  Font::small, Align::left, kInk);
      Raster raster(cells, cells);
      for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x)
          raster.set(x, y, scale.color(value_at(matrix, panel, y, side, x)));
      canvas.paint(raster, left, top + kLabel, kPanel, kPanel);
    }
    draw_color_bar(canvas, scale, left, height - kColorBarHeight - kMargin / 2, kPanel, {});
  }
  return canvas.bytes();
}

}  // namespace lamella
