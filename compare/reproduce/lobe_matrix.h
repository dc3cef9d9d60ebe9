#pragma once

#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Orders 2 and up, or all, of a whole BSDF for the eye, as SpongeCake's figures 10, 13 and 22 have
/// it: a pixel row per incident direction, a pixel column per outgoing cell.
struct LobeMatrix {
  CellGrid grid;  ///< unfolded; the incident directions are one per cell of it
  struct Panel {
    std::string label;
    std::vector<double> values;  ///< f [1/sr]: [incident][side][cell], phi relative to w_i
    bool difference = false;     ///< has a scale of its own, symmetric about 0
  };
  std::vector<Panel> panels;
  std::string title, subtitle;
};

/// The file's bytes: the upper row is reflection, the lower one transmission. In each panel rows
/// are the incident directions, from the normal down and by azimuth within a step of mu^2, columns
/// the outgoing cells in the same order, azimuths absolute. Magnitudes of a side share a scale.
/// Equal input gives equal bytes. Throws PictureError without Cairo.
[[nodiscard]] std::string draw_lobe_matrix(const LobeMatrix& matrix, PictureFormat format);

/// The incident directions of such a matrix: at the middle of every step of mu^2, and at azimuths
/// of cells' edges, so that a cell of relative azimuth is one of absolute azimuth.
struct MatrixDirection {
  double mu, phi;
};
[[nodiscard]] std::vector<MatrixDirection> matrix_directions(const CellGrid& grid);

}  // namespace lamella
