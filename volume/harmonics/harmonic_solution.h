#pragma once

#include <array>
#include <memory>
#include <vector>

#include "volume/harmonics/harmonic_transport.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// Orders 2, 3 and 4 and more, as they are kept apart; then order 2 without what mirrors scatter
/// twice (mirror_pairs.h has that at any accuracy); and orders 1 and 0 where rough boundaries leave
/// them without a closed form (ClosedOrders).
inline constexpr int kHarmonicOrders = 3;
inline constexpr int kHarmonicParts = 6;
inline constexpr int kWithoutPairs = 3, kFirstPart = 4, kZeroPart = 5;
/// Without boundaries there are the first four.
inline constexpr int kOpenParts = 4;
/// The parts that a sum over all orders has, but for closed ones.
inline constexpr std::array<int, 5> kSummedParts{0, 1, 2, kFirstPart, kZeroPart};

/// Shares of a beam, by order: 1, 2, 3, 4+.
struct HarmonicEnergies {
  std::array<double, 4> up{}, down{};  ///< that leave through the top, the bottom
  double uncollided = 0, absorbed = 0;
  double zero_up = 0, zero_down = 0;  ///< of order 0, deltas apart
  double mirrored = 0;                ///< as a delta, by smooth boundaries alone
  double specular = 0;                ///< as deltas of all orders, parts of `mirrored` and `up`
  double lost = 0;                    ///< by single scattering at rough boundaries

  [[nodiscard]] double sum() const;
};

/// Means over cells of one side, by part and cell, and what their quadrature leaves. A part that a
/// stack does not have is empty.
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
  /// f of all orders from 2 on together, along directions whose harmonics are the columns.
  [[nodiscard]] Eigen::VectorXd multiple(std::span<const Direction> wo,
                                         const Eigen::MatrixXd& harmonics) const;
  /// tolerance: of a mean, relative to the mean over its row. The quadrature over cells takes more
  /// points until it leaves a tenth of that, up to 8 x 10 of them.
  [[nodiscard]] HarmonicCells cells(const CellGrid& grid, bool up, double tolerance) const;

 private:
  [[nodiscard]] std::array<std::vector<double>, kOpenParts> means(const CellGrid& grid, bool up,
                                                                  int points) const;

  const HarmonicTransport& transport_;
  Direction wi_;
  std::array<HarmonicSource, kOpenParts> sources_;
  std::array<double, kOpenParts> ground_{};
  HarmonicEnergies energies_;
};

}  // namespace lamella
