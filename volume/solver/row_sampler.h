#pragma once

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <functional>
#include <vector>

#include "volume/result/cell_grid.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// Orders that rows of cells are solved for: 2, 3, 4+; where a boundary is rough, 1 and 0 as well.
inline constexpr int kModeOrders = 3, kFirstInModes = 3, kZeroInModes = 4, kAllModeOrders = 5;
/// Share of the tolerance for each quadrature over cells: that in mu, and that of order 1.
inline constexpr double kQuadratureShare = 0.1;

/// Azimuthal modes of the mean over one row of cells, or over a part of it.
struct RowModes {
  std::array<std::vector<double>, kAllModeOrders> mode;  ///< [order][m], orders as above
  double scale = 0;                                      ///< what errors are relative to
  double error = 0;                                      ///< of all orders together, but order 1

  RowModes& operator+=(const RowModes& part);
};

/// Cosines of outgoing directions, on either side, about which f is not smooth.
struct PanelEdges {
  std::vector<double> steep;  ///< f behaves like x log x of the distance x
  std::vector<double> root;   ///< like the root of x: critical angles
};

/// Cosine-weighted means of a solution's modes over the rows of a grid, by Gauss-Legendre panels in
/// mu whose points are doubled until what they leave is within a share of the tolerance.
class RowSampler {
 public:
  /// Panels end at `edges`. `stop`, where there is one, ends the doubling once it is true; bounds
  /// say what that leaves. `report` is told what share of the panels is done.
  RowSampler(const DeterministicSolution& solution, const CellGrid& grid, int channels,
             bool both_sides, std::vector<double> mu_i, const PanelEdges& edges, double tolerance,
             const std::atomic<bool>* stop, const std::function<void(double share)>& report);

  /// Incident direction i of the list.
  [[nodiscard]] const RowModes& row(std::size_t i, int channel, bool up, int row) const {
    return rows_[((i * channels_ + channel) * sides_ + (up ? 0 : 1)) * grid_.rows() + row];
  }

 private:
  struct Panel;
  // Solves for the panels' points; returns those that need more of them.
  std::vector<Panel> sample(const std::vector<Panel>& panels);
  // The panel's part of its rows, and whether its points are enough for this direction, channel and
  // side, whose points begin at `first`.
  bool take(const Panel& panel, const Eigen::MatrixXd& weights, const Eigen::MatrixXd& transform,
            const DeterministicField& field, std::size_t i, int channel, std::size_t first,
            RowModes* parts) const;

  const DeterministicSolution& solution_;
  const CellGrid& grid_;
  int channels_, sides_;
  int orders_;  // of kAllModeOrders
  std::vector<double> mu_i_;
  double tolerance_;
  const std::atomic<bool>* stop_;
  std::vector<RowModes> rows_;
};

}  // namespace lamella
