#pragma once

#include <span>
#include <vector>

#include "analytic/model/model.h"
#include "volume/result/run_result.h"

namespace lamella {

/// What a truth of walks that were cut may lack. A walk that --max-order cuts holds energy (the
/// ledger's `unresolved`, of the light that came in) that would have left in orders beyond the
/// limit, or would have been absorbed. So the energies of the lobes that are cut are too low by at
/// most that, all of them together, and none is too high.
///
/// Per cell no more is known of an arbitrary medium than that one cell may lack everything: its
/// mean of f is too low by at most unresolved / (projected solid angle of a cell), and the sum over
/// the cells of both sides of what they lack stays below the same number.

/// Standard errors of the ledger's `unresolved` that are added to it, as it is an estimate.
inline constexpr double kUnresolvedErrors = 3;

/// Whether the cut takes light from this order's lobe: 1, 2, 3 where they lie beyond the limit,
/// 4+ and all wherever a walk was cut.
[[nodiscard]] bool is_cut(const RunResult& run, Order order);

/// Per channel, how much the energy of this order's lobe may be too low; zeros where it is whole.
[[nodiscard]] std::vector<double> missing_energy(const RunResult& run, Order order);

/// What the cells of a lobe may lack, as the squared difference from a model has it. All lists are
/// [channel][cell]; budget: per channel, the most that the sum over the cells of their means of f
/// may be too low.
struct SquaredDifferences {
  double least = 0;  ///< mean over the cells, with the missing light where it suits the model best
  double most = 0;   ///< and where it suits it worst
};
[[nodiscard]] SquaredDifferences squared_differences(std::span<const double> model,
                                                     std::span<const double> truth,
                                                     std::span<const double> budget);

/// The largest mean square of the truth's cells that the missing light allows.
[[nodiscard]] double most_mean_square(std::span<const double> truth,
                                      std::span<const double> budget);

}  // namespace lamella
