#pragma once

#include <array>
#include <memory>
#include <vector>

#include "volume/harmonics/harmonic_transport.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Orders 2, 3 and 4 and more, as they are kept apart.
inline constexpr int kHarmonicOrders = 3;

/// Shares of a beam, by order: 1, 2, 3, 4+.
struct HarmonicEnergies {
  std::array<double, 4> up{}, down{};  ///< that leave through the top, the bottom
  double uncollided = 0, absorbed = 0;

  [[nodiscard]] double sum() const;
};

/// Means over cells of one side, by order and cell: orders 2, 3, 4+; and what their quadrature
/// leaves.
struct HarmonicCells {
  std::array<std::vector<double>, kHarmonicOrders> value;
  std::vector<double> error;
};

/// The light of one beam in one channel, at one resolution.
class HarmonicSolution {
 public:
  HarmonicSolution(const HarmonicTransport& transport, Direction wi);

  [[nodiscard]] const HarmonicEnergies& energies() const { return energies_; }
  /// f [1/sr] of orders 2, 3, 4+.
  [[nodiscard]] std::array<double, kHarmonicOrders> f(Direction wo) const;
  [[nodiscard]] HarmonicCells cells(const CellGrid& grid, bool up) const;

 private:
  [[nodiscard]] std::array<std::vector<double>, kHarmonicOrders> means(const CellGrid& grid,
                                                                       bool up, int points) const;

  const HarmonicTransport& transport_;
  Direction wi_;
  std::array<HarmonicSource, kHarmonicOrders> sources_;
  std::array<double, kHarmonicOrders> ground_{};
  HarmonicEnergies energies_;
};

}  // namespace lamella
