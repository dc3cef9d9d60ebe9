#include <fmt/format.h>

#include "phase/parameters/toml_text.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

std::string grid_text(const GridReference& grid) {
  std::string text =
      fmt::format("grid = {}\nsize = [{}, {}]\ngrid_albedo = \"{}\"\n", quoted(grid.file),
                  to_text(grid.size_x), to_text(grid.size_y), grid.white ? "white" : "file");
  for (std::size_t k = 0; k < grid.names.size(); ++k)
    if (!grid.names[k].empty())
      text += fmt::format("{} = {}\n", kGridNameKeys[k], quoted(grid.names[k]));
  if (grid.voxels) {
    const auto& n = *grid.voxels;
    const auto& first = grid.first_voxel;
    text += fmt::format("voxels = [{}, {}, {}]\nfirst_voxel = [{}, {}, {}]\n", n[0], n[1], n[2],
                        first[0], first[1], first[2]);
  }
  return text;
}

}  // namespace

std::string to_toml(const Stack& stack) {
  std::string text;
  for (const Layer& layer : stack.layers) {
    text += fmt::format("[[layer]]\n{} = \"{}\"\n", layer.interface ? "interface" : "medium",
                        layer.medium_name);
    for (const auto& [key, value] : layer.parameters.all())
      text += fmt::format("{} = {}\n", key, to_text(value));
    if (layer.interface) {
      text += '\n';
      continue;
    }
    text += fmt::format("albedo = {}\n", to_text(layer.albedo));
    if (!layer.grains)
      text += fmt::format("thickness = {}\ndensity = {}\n", to_text(layer.thickness),
                          to_text(layer.density));
    if (layer.grid) text += grid_text(*layer.grid);
    text += '\n';
  }
  if (stack.substrate && !stack.substrate->model.empty()) {
    text += fmt::format("[substrate]\nbsdf = {}\n", quoted(stack.substrate->model));
    for (const auto& [key, value] : stack.substrate->parameters.all())
      text += fmt::format("{} = {}\n", toml_key(key), to_text(value));
  } else if (stack.substrate) {
    text += fmt::format("[substrate]\nbsdf = \"lambert\"\nalbedo = {}\n",
                        to_text(ParameterValue(stack.substrate->albedo)));
  }
  return text;
}

}  // namespace lamella
