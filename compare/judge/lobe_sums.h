#pragma once

#include <vector>

#include "compare/judge/statistics.h"
#include "volume/run/simulation.h"

namespace lamella {

/// Effective events from which on a mean over batches is near enough to normal in the tails that
/// decide a report's p-values.
inline constexpr double kPooledEvents = 100;

/// Groups that the cells of one side belong to, [channel][cell]; no group holds two channels.
struct CellGroups {
  std::vector<int> group;
  int count = 0;
};
/// Each cell of each channel by itself.
[[nodiscard]] CellGroups single_cells(const CellGrid& grid, int channels);
/// A few patches of the hemisphere per channel, which show broad differences that no single cell
/// shows: 4 x 4 in grey, 4 x 2 in colour, fewer where there are fewer cells. Every channel has the
/// same number of patches.
[[nodiscard]] CellGroups cell_patches(const CellGrid& grid, int channels);

/// Per batch, the sums of one lobe over groups of its cells. `up`: the side; `order`: as in
/// SideResult::lobes; `first`: the first slot that lobes of several orders have.
[[nodiscard]] BatchSums lobe_sums(const Simulation& simulation, bool up, int order,
                                  const CellGroups& groups, int first = 0);

}  // namespace lamella
