#pragma once

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {

/// Cells that tile one hemisphere of outgoing directions: equal steps in mu^2 and in phi, hence
/// equal projected solid angles. Row 0 holds normal directions; phi is the azimuth of w_o relative
/// to w_i, column 0 starts at phi = 0 (the side of the light). A folded grid stores the columns of
/// [0, pi) only; each of its cells stands for phi and -phi.
struct CellGrid {
  int mu_cells = 16;
  int phi_cells = 32;  ///< over the whole circle, folded or not; even if folded
  bool folded = false;

  [[nodiscard]] int rows() const { return mu_cells; }
  [[nodiscard]] int columns() const { return folded ? phi_cells / 2 : phi_cells; }
  [[nodiscard]] int cells() const { return rows() * columns(); }

  /// Projected solid angle [sr] of each stored cell; they sum to pi.
  [[nodiscard]] double projected_solid_angle() const { return kPi / cells(); }

  /// |mu| at the lower edge of a row (row = mu_cells gives 0 ... row = 0 gives 1).
  [[nodiscard]] double edge_mu(int edge) const {
    return std::sqrt(1 - static_cast<double>(edge) / mu_cells);
  }
  [[nodiscard]] double edge_phi(int edge) const { return 2 * kPi * edge / phi_cells; }

  /// The cell of a direction with squared cosine mu2 whose azimuth relative to w_i is phi, in
  /// [0, 2 pi).
  [[nodiscard]] int cell(double mu2, double phi) const {
    if (folded && phi > kPi) phi = 2 * kPi - phi;
    const int row = std::clamp(static_cast<int>((1 - mu2) * mu_cells), 0, mu_cells - 1);
    const int column = std::clamp(static_cast<int>(phi / (2 * kPi) * phi_cells), 0, columns() - 1);
    return row * columns() + column;
  }

  friend bool operator==(const CellGrid&, const CellGrid&) = default;
};

}  // namespace lamella
