#pragma once

#include <memory>
#include <string>

#include "tests/volume/run/stacks.h"
#include "volume/voxels/density_grid.h"

namespace lamella::testing {

/// A layer with a grid of that name; keys: the others. The voxels come from the test.
[[nodiscard]] inline std::string grid_layer(const std::string& keys, double size_x = 1,
                                            double size_y = 1) {
  return layer(keys + "\ngrid = 'test.vdb'\nsize = [" + std::to_string(size_x) + ", " +
               std::to_string(size_y) + "]");
}

/// The plan of a stack whose first layer with a grid holds these voxels, and so on.
[[nodiscard]] inline Plan plan_with(const Stack& stack,
                                    const std::vector<std::shared_ptr<const Voxels>>& voxels,
                                    MajorantCells cells = MajorantCells::adaptive) {
  std::vector<std::shared_ptr<const DensityGrid>> grids(stack.layers.size());
  std::size_t next = 0;
  for (std::size_t k = 0; k < grids.size(); ++k)
    if (stack.layers[k].grid)
      grids[k] = std::make_shared<DensityGrid>(stack.layers[k], voxels.at(next++), cells);
  return make_plan(stack, {}, grids);
}

/// Voxels whose density is f(index).
template <class F>
[[nodiscard]] Voxels voxels_of(VoxelIndex n, const F& f) {
  Voxels out(VoxelExtent{n});
  for_each_voxel(out.extent(),
                 [&](VoxelIndex i) { out.density.set(i, {static_cast<float>(f(i))}); });
  return out;
}

template <class F>
[[nodiscard]] std::shared_ptr<const Voxels> shared_voxels_of(VoxelIndex n, const F& f) {
  return std::make_shared<const Voxels>(voxels_of(n, f));
}

/// A number in [0, 1) that looks random, by voxel.
[[nodiscard]] inline double scrambled(VoxelIndex i, int salt = 0) {
  return RandomStream(salt, (static_cast<std::uint64_t>(i[2]) * 4096 + i[1]) * 4096 + i[0],
                      StreamPurpose::test)
      .uniform();
}

}  // namespace lamella::testing
