#pragma once

#include <Eigen/Core>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Whether a layer has Lambertian flakes, whose phase function is an integral over their normals.
[[nodiscard]] bool is_diffuse(const Layer& layer);

/// Order 1 of the layers of Lambertian flakes alone, on the cells of one side: cosine-weighted
/// means of f [1/sr]. Their axes are vertical and there are no boundaries. tolerance: absolute,
/// what the quadrature over a row may leave; errors have the modes that are left out, too.
[[nodiscard]] std::vector<CellMean> diffuse_cells(const Stack& stack, const CellGrid& grid,
                                                  Direction wi, bool up, double tolerance);

/// The mean over the azimuth of the same at the cosine |mu_o|.
[[nodiscard]] Rgb diffuse_mean(const Stack& stack, Direction wi, bool up, double mu_o);

/// The mean over each column of cells (rows of the result) of cos(m (pi - phi)), m < modes.
[[nodiscard]] Eigen::MatrixXd column_cosines(const CellGrid& grid, int modes);

}  // namespace lamella
