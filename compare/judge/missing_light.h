#pragma once

#include <span>
#include <vector>

#include "analytic/model/model.h"
#include "volume/result/run_result.h"

namespace lamella {

/// The light that a truth of walks may lack because walks were cut. A walk that --max-order cuts
/// holds energy (the ledger's `unresolved`, a share of the light that came in) that would have left
/// in orders beyond the limit, or would have been absorbed. So the energies of the lobes that are
/// cut are too low by at most this energy, all of them together, and none is too high.
///
/// For an arbitrary medium one cell may lack all of this light: its mean of f is too low by at most
/// unresolved / (projected solid angle of a cell). The sum of the deficits over the cells of both
/// sides stays below the same number.

/// Standard errors of the ledger's `unresolved` that are added to it, as it is an estimate.
inline constexpr double kUnresolvedErrors = 3;

/// Whether the cut takes light from this order's lobe: 1, 2, 3 where they lie beyond the limit,
/// 4+ and all wherever a walk was cut.
[[nodiscard]] bool is_cut(const RunResult& run, Order order);

/// Per channel, how much the energy of this order's lobe may be too low; zeros where it is whole.
[[nodiscard]] std::vector<double> missing_energy(const RunResult& run, Order order);

/// The range of the mean squared difference from a model, as cells may lack light. All lists are
/// [channel][cell]; budget: per channel, the largest deficit of the sum of the cells' means of f.
struct SquaredDifferences {
  double least = 0;  ///< mean over the cells, with the missing light where the model fits best
  double most = 0;   ///< the same, with the missing light where the model fits worst
};
[[nodiscard]] SquaredDifferences squared_differences(std::span<const double> model,
                                                     std::span<const double> truth,
                                                     std::span<const double> budget);

/// The largest mean square of the truth's cells that the missing light allows.
[[nodiscard]] double most_mean_square(std::span<const double> truth,
                                      std::span<const double> budget);

}  // namespace lamella
