#pragma once

#include <optional>
#include <vector>

#include "volume/harmonics/harmonic_solution.h"

namespace lamella {

/// One direction in one channel.
struct HarmonicAnswer {
  HarmonicEnergies energies;
  std::array<HarmonicCells, 2> sides;  ///< up, down
};

/// The answers of one degree, by distinct channel and direction.
struct HarmonicLevel {
  int degree = 0;
  std::size_t bytes = 0;  ///< of the operators of boundaries, or of all without boundaries
  std::vector<std::vector<HarmonicAnswer>> answers;
};

/// The solutions of rising degree, and the bounds that follow from how they change. A bound is the
/// change under the last step, of the cell or the root mean square over its row, whichever is
/// larger; where the steps before have fallen, kSafety times what the next one would be.
class HarmonicLevels {
 public:
  explicit HarmonicLevels(CellGrid grid) : grid_(grid) {}

  void add(HarmonicLevel level);
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] const HarmonicLevel& last() const { return now_; }
  /// The bound of one part of a cell, what its quadrature leaves included.
  [[nodiscard]] double error(int channel, std::size_t i, bool up, int cell, int part) const;

  /// An energy's last change, and what the ledger lacks.
  template <class Energy>
  [[nodiscard]] double bound_of(int channel, std::size_t i, const Energy& energy) const {
    const HarmonicEnergies& e = now_.answers[channel][i].energies;
    const double before =
        before_.answers.empty() ? 0 : energy(before_.answers[channel][i].energies);
    return std::abs(energy(e) - before) + std::abs(e.sum() - 1);
  }

 private:
  // How one part of one side changed.
  struct Change {
    std::vector<double> of_row;  // root mean square over each row
    double worst = 0;            // over all rows, relative to their means
    double ahead = 1;            // share of the last change that is still to come
  };
  Change& change(int channel, std::size_t i, bool up, int part);
  [[nodiscard]] const Change& change(int channel, std::size_t i, bool up, int part) const;
  void compare(int channel, std::size_t i, bool up, int part);

  CellGrid grid_;
  HarmonicLevel now_, before_;
  int count_ = 0;
  std::vector<Change> changes_;
};

}  // namespace lamella
