#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "analytic/layered/spongecake.h"
#include "compare/ensemble/multiple_lobes.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// How far a closed form is from a stack's truth: the root mean square of the differences over that
/// of the truth, over cells of all directions, sides and channels, the noise of walks taken off
/// both.
struct LobeErrors {
  double multiple = 0;  ///< of orders 2 and up
  double all = 0;       ///< of all orders; the first is exact
};

/// A held-out stack: what is left over without lobes, with those of the network, with the best
/// two.
struct SpongecakeAccuracy {
  Stack stack;
  double noise = 0;  ///< of the truth, per cell
  /// Share of the energy that orders 2 and up are of all that is scattered.
  double multiple_share = 0;
  LobeErrors nothing, network;
  /// Absent without Ceres. `fit` is fitted to the cells that it is judged on, the least that the
  /// form can leave there; `fit_elsewhere` to as many directions of its own.
  std::optional<LobeErrors> fit{}, fit_elsewhere{};
};

/// What the measurement runs over: stacks of an ensemble whose seed is not that of the training.
struct AccuracyEnsemble {
  std::uint64_t one_layer = 250, two_layers = 250, walks = 131072, seed = 1000001;
  int directions = 4;
};

/// One stack after the other, in order; until the monitor says stop. The monitor's progress counts
/// stacks. Throws NonFiniteError.
void measure_spongecake_accuracy(const AccuracyEnsemble& ensemble, const RunMonitor& monitor,
                                 const std::function<void(const SpongecakeAccuracy&)>& take);

/// A stack's truth (8 x 16 cells), and lobes held against it.
class SpongecakeTrial {
 public:
  SpongecakeTrial(const Stack& stack, const MultipleLobes& truth);

  /// fit_two_lobes.
  [[nodiscard]] SpongecakeLobes best(const StopFlag* stop = nullptr) const;
  /// None: nothing in their place.
  [[nodiscard]] LobeErrors errors_of(const std::optional<SpongecakeLobes>& lobes) const;
  [[nodiscard]] double multiple_share() const;
  /// Mean of f over the cells, [direction][side][cell], of the truth, of exact order 1 and of two
  /// lobes.
  [[nodiscard]] std::vector<Rgb> truth() const;
  [[nodiscard]] const std::vector<Rgb>& single() const { return single_; }
  [[nodiscard]] std::vector<Rgb> values(const SpongecakeLobes& lobes) const;

 private:
  Stack stack_;
  std::vector<Direction> incident_;
  std::vector<std::size_t> direction_;  // of each cell
  std::vector<int> row_, column_;
  std::vector<bool> reflected_;
  CellGrid grid_;
  std::vector<Rgb> truth_, variance_, single_;
};

}  // namespace lamella
