#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/harmonics/harmonic_levels.h"
#include "volume/plan/plan.h"
#include "volume/quadrature/cell_quadrature.h"
#include "volume/result/run_result.h"

namespace lamella {

/// Cells and ledgers as they follow from solutions of rising degree, from what is closed, and from
/// what mirrors scatter twice; with the bounds of all of them. i: number of a direction; c: colour
/// channel; up: the side.
class HarmonicLobes {
 public:
  HarmonicLobes(const Stack& stack, const Plan& plan, std::span<const Direction> incident,
                CellGrid grid);

  HarmonicLevels levels;
  /// What is closed, by direction, up and down; empty where nothing leaves.
  std::vector<std::vector<CellMean>> closed;
  /// By direction, up and down, and cell: order 2 by pairs of mirrors, where it was integrated.
  std::vector<std::vector<std::optional<CellMean>>> pairs;

  [[nodiscard]] const std::vector<Direction>& incident() const { return incident_; }
  [[nodiscard]] const std::vector<int>& channels() const { return channels_; }
  [[nodiscard]] int channel_of(int c) const { return channel_of_[c]; }
  [[nodiscard]] double lowest() const { return lowest_; }  ///< |mu_i|
  [[nodiscard]] bool is_first_closed() const { return is_first_closed_; }

  [[nodiscard]] bool sees(std::size_t i, bool up) const;
  [[nodiscard]] const std::vector<CellMean>& closed_of(std::size_t i, bool up) const {
    return closed[2 * i + (up ? 0 : 1)];
  }
  /// Whether a cell's order 2 is the sum of what mirrors scatter twice, by quadrature, and the
  /// rest.
  [[nodiscard]] const std::optional<CellMean>& pairs_of(std::size_t i, bool up, int cell) const {
    return pairs[2 * i + (up ? 0 : 1)][cell];
  }
  /// One of kSummedParts of a cell; 0 where there is none.
  [[nodiscard]] double value_of(int c, std::size_t i, bool up, int cell, int part) const;
  [[nodiscard]] double error_of(int c, std::size_t i, bool up, int cell, int part) const;
  /// The mean of a row of all that is not closed, by distinct channel; over all orders.
  [[nodiscard]] double row_mean(int channel, std::size_t i, bool up, int row) const;
  [[nodiscard]] double scale_of(int c, std::size_t i, bool up, int row) const;
  /// The largest bound of a cell, relative to the mean of its row.
  [[nodiscard]] double worst(int c, std::size_t i, bool up) const;
  [[nodiscard]] const HarmonicEnergies& energies_of(int c, std::size_t i) const;

  /// In the form that walks give results in.
  [[nodiscard]] std::vector<RunResult> results(const DeterministicAccuracy& accuracy,
                                               double tolerance) const;

 private:
  void fill_energies(SideResult& side, std::size_t i, bool up) const;
  void fill_lobes(SideResult& side, std::size_t i, bool up) const;

  const Plan& plan_;
  CellGrid grid_;
  bool is_first_closed_, is_open_below_;
  std::vector<Direction> incident_;
  double lowest_ = 1;
  std::vector<int> channels_;
  std::array<int, 3> channel_of_{};
};

}  // namespace lamella
