#pragma once

#include <array>
#include <memory>
#include <vector>

#include "volume/harmonics/harmonic_transport.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Orders 2, 3 and 4 and more, as they are kept apart; and, as the last part, order 2 without what
/// mirrors scatter twice (mirror_pairs.h has that at any accuracy).
inline constexpr int kHarmonicOrders = 3;
inline constexpr int kHarmonicParts = 4;
inline constexpr int kWithoutPairs = 3;

/// Shares of a beam, by order: 1, 2, 3, 4+.
struct HarmonicEnergies {
  std::array<double, 4> up{}, down{};  ///< that leave through the top, the bottom
  double uncollided = 0, absorbed = 0;

  [[nodiscard]] double sum() const;
};

/// Means over cells of one side, by part and cell, and what their quadrature leaves.
struct HarmonicCells {
  std::array<std::vector<double>, kHarmonicParts> value, error;
};

/// The light of one beam in one channel, at one resolution.
class HarmonicSolution {
 public:
  HarmonicSolution(const HarmonicTransport& transport, Direction wi);

  [[nodiscard]] const HarmonicEnergies& energies() const { return energies_; }
  /// f [1/sr] by part.
  [[nodiscard]] std::array<double, kHarmonicParts> f(Direction wo) const;
  [[nodiscard]] HarmonicCells cells(const CellGrid& grid, bool up) const;

 private:
  [[nodiscard]] std::array<std::vector<double>, kHarmonicParts> means(const CellGrid& grid, bool up,
                                                                      int points) const;

  const HarmonicTransport& transport_;
  Direction wi_;
  std::array<HarmonicSource, kHarmonicParts> sources_;
  std::array<double, kHarmonicParts> ground_{};
  HarmonicEnergies energies_;
};

}  // namespace lamella
