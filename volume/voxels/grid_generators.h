#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "phase/parameters/parameters.h"
#include "volume/voxels/voxels.h"

namespace lamella {

/// A generated tile: voxels, and the lengths [mm] that a stack file gives them.
struct GeneratedGrid {
  Voxels voxels;
  double size_x, size_y, thickness;
  std::string medium;  ///< keys of a layer that it is meant for, without grid, size and thickness
};

/// A kind of grid that `lamella grid` makes.
struct GridGenerator {
  std::string name;
  std::string doc;
  std::vector<ParameterInfo> parameters;
  std::function<GeneratedGrid(const Parameters&)> make;  ///< parameters: checked, complete
};

/// weave: plain weave of two directions of yarns with elliptic cross-sections, the fibers' flakes
/// along the yarn (grid "orientation"), turned about its core by the twist.
/// dust: density that falls off exponentially above the bottom, its height modulated laterally.
/// blotches: density modulated in all directions by gradient noise (Perlin 2002, "Improving
/// noise"), periodic in x and y.
[[nodiscard]] const std::vector<GridGenerator>& grid_generators();
[[nodiscard]] const GridGenerator* find_grid_generator(std::string_view name);

/// The name in "builtin:NAME"; nothing if the file has another form.
[[nodiscard]] std::optional<std::string> builtin_grid_name(const std::string& file);

/// The generator's grid with its default parameters. Throws std::invalid_argument if there is none
/// of that name.
[[nodiscard]] Voxels make_builtin_grid(const std::string& name);

}  // namespace lamella
