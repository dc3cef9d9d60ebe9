#include "compare/judge/lobe_sums.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace lamella {

CellGroups single_cells(const CellGrid& grid, int channels) {
  CellGroups groups{.group = std::vector<int>(static_cast<std::size_t>(channels) * grid.cells()),
                    .count = channels * grid.cells()};
  std::iota(groups.group.begin(), groups.group.end(), 0);
  return groups;
}

CellGroups cell_patches(const CellGrid& grid, int channels) {
  const int rows = std::min(4, grid.rows());
  const int columns = std::min(channels == 1 ? 4 : 2, grid.columns());
  CellGroups groups{.group = {}, .count = channels * rows * columns};
  for (int c = 0; c < channels; ++c)
    for (int row = 0; row < grid.rows(); ++row)
      for (int column = 0; column < grid.columns(); ++column)
        groups.group.push_back((c * rows + row * rows / grid.rows()) * columns +
                               column * columns / grid.columns());
  return groups;
}

BatchSums lobe_sums(const Simulation& simulation, bool up, int order, const CellGroups& groups,
                    int first) {
  const CellTargets& targets = simulation.targets();
  const int channels = simulation.plan().channels, cells = targets.grid.cells();
  const int count = targets.count();
  BatchSums out;
  for (const BatchTally& batch : simulation.batches()) {
    out.walks.push_back(static_cast<double>(batch.walks));
    std::vector<double> row(groups.count);
    const bool multiple = order == place(Order::multiple);
    const bool summed = order == kTallyOrders || order == place(Order::scattered) || multiple;
    const int slots = order == place(Order::scattered) || multiple
                          ? kTallyOrders
                          : simulation.plan().order_slots();
    for (int o = multiple ? place(Order::two) : summed ? first : 0; o < slots; ++o) {
      if (!summed && o != (order == place(Order::zero) ? kZeroSlot : order)) continue;
      for (int c = 0; c < channels; ++c)
        for (int cell = 0; cell < cells; ++cell)
          row[groups.group[static_cast<std::size_t>(c) * cells + cell]] +=
              batch.f[(static_cast<std::size_t>(o) * channels + c) * count +
                      target_of(targets, up, cell)];
    }
    out.sums.push_back(std::move(row));
  }
  return out;
}

}  // namespace lamella
