#include "phase/stack/grid_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace lamella {
namespace {

const ParameterInfo kGridAlbedo{.name = "grid_albedo",
                                .kind = ParameterKind::choice,
                                .unit = "1",
                                .doc = "the albedo grid of the file, or white: as if it had none",
                                .default_value = "file",
                                .choices = {"file", "white"}};

constexpr char kBuiltinPrefix[] = "builtin:";
// Voxels along an edge of a tile, and places of its first one: OpenVDB's indices have 32 bits.
constexpr double kMostVoxels = 1 << 20, kFarthestVoxel = 1 << 30;

// Lengths [mm] of a grid, so that voxel sizes and their inverses stay far from the ends of double.
constexpr double kSmallestLength = 1e-6, kLargestLength = 1e6;

// What is taken of a .vdb file: names of its grids, and its tile.
void read_contents(const KeyReader& keys, const toml::table& table, const std::string& where,
                   GridReference& grid) {
  const bool is_file = !grid.file.starts_with(kBuiltinPrefix);
  const auto must_be_file = [&](const toml::node& node, const std::string& key) {
    if (!is_file)
      keys.fail(node.source(),
                fmt::format("{}: key \"{}\": found {} beside \"{}\"; allowed: beside a "
                            ".vdb file only",
                            where, key, text_of(node), grid.file));
  };
  for (std::size_t k = 0; k < kGridNameKeys.size(); ++k)
    if (const toml::node* node = table.get(kGridNameKeys[k])) {
      must_be_file(*node, kGridNameKeys[k]);
      grid.names[k] =
          keys.read_name(*node, where, kGridNameKeys[k], "the name of a grid in the file");
    }
  if (const toml::node* node = table.get("voxels")) {
    must_be_file(*node, "voxels");
    grid.voxels = keys.read_counts(*node, where, "voxels", 1, kMostVoxels, "the tile in voxels");
  }
  if (const toml::node* node = table.get("first_voxel")) {
    if (!grid.voxels)
      keys.fail(node->source(), fmt::format("{}: key \"first_voxel\": found {} without \"voxels\"; "
                                            "allowed: beside \"voxels\" only",
                                            where, text_of(*node)));
    grid.first_voxel = keys.read_counts(*node, where, "first_voxel", -kFarthestVoxel,
                                        kFarthestVoxel, "the index of the tile's lowest voxel");
  }
}

}  // namespace

const std::vector<std::string>& grid_keys() {
  static const std::vector<std::string> keys{"grid",           "size",           kGridAlbedo.name,
                                             kGridNameKeys[0], kGridNameKeys[1], kGridNameKeys[2],
                                             kGridNameKeys[3], "voxels",         "first_voxel"};
  return keys;
}

std::optional<GridReference> read_grid(const KeyReader& keys, const toml::table& table,
                                       const std::string& where, double thickness) {
  const toml::node* grid = table.get("grid");
  const toml::node* size = table.get("size");
  const toml::node* albedo = table.get(kGridAlbedo.name);
  if (!grid) {
    for (const std::string& key : grid_keys())
      if (const toml::node* node = table.get(key))
        keys.fail(node->source(), fmt::format("{}: key \"{}\": found {} without a grid; allowed: "
                                              "beside \"grid\" only",
                                              where, key, described(*node)));
    return std::nullopt;
  }
  GridReference out;
  out.file = keys.read_name(*grid, where, "grid", "the name of a .vdb file");
  out.folder = std::filesystem::path(keys.file()).parent_path().string();
  out.where = fmt::format("{}:{}: {}", keys.file(), grid->source().begin.line, where);
  if (!(thickness >= kSmallestLength && thickness <= kLargestLength))
    keys.fail(
        table.get("thickness")->source(),
        fmt::format("{}: key \"thickness\": found {} beside \"grid\"; allowed: a number in "
                    "[{}, {}], the height of the grid in mm",
                    where, to_text(thickness), to_text(kSmallestLength), to_text(kLargestLength)));
  std::vector<double> lengths;
  if (size)
    if (const auto value = to_value(*size))
      if (const auto* list = std::get_if<std::vector<double>>(&*value)) lengths = *list;
  if (lengths.size() != 2 || !std::all_of(lengths.begin(), lengths.end(), [](double x) {
        return x >= kSmallestLength && x <= kLargestLength;
      }))
    keys.fail(
        size ? size->source() : grid->source(),
        fmt::format("{}: key \"size\": found {}; allowed: two numbers [x, y] in [{}, {}], the "
                    "lateral period in mm",
                    where, size ? text_of(*size) : "nothing", to_text(kSmallestLength),
                    to_text(kLargestLength)));
  out.size_x = lengths[0];
  out.size_y = lengths[1];
  read_contents(keys, table, where, out);
  if (albedo) {
    const auto* word = albedo->as_string();
    try {
      out.white =
          std::get<std::string>(checked(
              kGridAlbedo, word ? ParameterValue(word->get()) : ParameterValue(0.0))) == "white";
    } catch (const ParameterError&) {
      keys.fail(albedo->source(),
                fmt::format("{}: key \"{}\": found {}; allowed: {}", where, kGridAlbedo.name,
                            described(*albedo), allowed_values(kGridAlbedo)));
    }
  }
  return out;
}

}  // namespace lamella
