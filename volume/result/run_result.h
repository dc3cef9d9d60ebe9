#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "volume/result/accuracy.h"
#include "volume/result/cell_grid.h"
#include "volume/result/estimator.h"
#include "volume/result/order_one.h"
#include "volume/result/tally.h"
#include "volume/result/thinning.h"
#include "volume/result/walk_sampling.h"

namespace lamella {

/// One lobe on the cells of one side: mean of f over each cell, [channel][cell], with standard
/// errors.
struct LobeEstimate {
  std::vector<double> value, standard_error;
};

/// The light that leaves on one side, for one incident direction.
struct SideResult {
  std::array<Estimate, 3> total{};     ///< share of the light that leaves on this side, per channel
  std::array<Estimate, 3> specular{};  ///< the part of `total` that met deltas only
  std::array<Estimate, 3> zero{};      ///< of order 0: interfaces alone, `uncollided` apart
  std::array<std::array<Estimate, 3>, kTallyOrders> orders{};
  std::array<Estimate, 3> multiple{};  ///< of orders 2 and up together
  /// Those of order 0 and of orders 1 and up only where a rough interface makes a lobe of order 0.
  /// Empty if light cannot leave here. Deltas are in none.
  OrderMap<LobeEstimate> lobes{};

  [[nodiscard]] bool has_zero_lobe() const { return !lobes[Order::zero].value.empty(); }
};

/// The result for one incident direction, whichever estimator found it. In a result of the
/// deterministic solver every standard_error is an error bound, and accuracy says what was reached.
struct RunResult {
  Direction incident{};
  Estimator estimator = Estimator::analog;
  CellGrid grid;
  int channels = 1;
  std::uint64_t walks = 0, collisions = 0;
  std::uint64_t max_order = 0;  ///< of walks; 0 from the solver
  Thinning thinning;
  Sampling sampling = Sampling::random;
  /// exact: the errors of order 1 and of `uncollided` are bounds, those of all orders have order 2
  /// and up of the walks and these bounds.
  OrderOne order_one = OrderOne::walked;
  double order_one_p_value = 1;  ///< of the walks' own order 1, where it is exact (first_check.h)
  std::uint64_t holes = 0;       ///< rays that began inside of explicit grains: a defect
  double seconds = 0;
  SideResult reflected, transmitted;
  std::array<Estimate, 3> uncollided{}, absorbed{}, unresolved{};
  std::array<Estimate, 3> lost{};     ///< by single scattering at rough interfaces
  std::array<Estimate, 3> thinned{};  ///< taken by thinning less given back: 0 on average
  std::optional<DeterministicAccuracy> accuracy{};

  [[nodiscard]] bool is_bounded() const { return accuracy.has_value(); }
  /// Whether the cells of this order's lobe have error bounds, no noise.
  [[nodiscard]] bool is_bounded(Order order) const {
    return is_bounded() || (order == Order::one && order_one == OrderOne::exact);
  }
};

/// Whether single scattering at rough interfaces has lost light.
[[nodiscard]] inline bool has_loss(const RunResult& run) {
  return run.lost[0].value > 0 || run.lost[1].value > 0 || run.lost[2].value > 0;
}

/// The sum of all parts of the ledger, 1 up to rounding.
[[nodiscard]] inline double ledger_sum(const RunResult& run, int c) {
  return run.reflected.total[c].value + run.transmitted.total[c].value + run.uncollided[c].value +
         run.absorbed[c].value + run.unresolved[c].value + run.lost[c].value + run.thinned[c].value;
}

}  // namespace lamella
