#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/percent.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"
#include "volume/voxels/density_grid.h"
#include "volume/voxels/depth_profile.h"
#include "volume/voxels/grid_generators.h"
#include "volume/voxels/sphere_bed_level_set.h"
#include "volume/voxels/vdb_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// No tile but a check: spheres as OpenVDB rasterises them.
const GridGenerator& sphere_check() {
  static const GridGenerator spheres{
      .name = "spheres",
      .doc =
          "no file: random overlapping spheres as level sets, their volume and area against the "
          "known ones",
      .parameters = {{.name = "radius",
                      .unit = "mm",
                      .doc = "of a sphere",
                      .default_value = "0.02",
                      .min = 1e-3,
                      .max = 1e3},
                     {.name = "packing",
                      .unit = "1",
                      .doc = "number density times sphere volume",
                      .default_value = "0.5",
                      .min = 1e-3,
                      .max = 5},
                     {.name = "voxels",
                      .unit = "1",
                      .doc = "per radius",
                      .default_value = "8",
                      .min = 2,
                      .max = 32},
                     {.name = "realisations",
                      .unit = "1",
                      .doc = "cubes of 12 radii",
                      .default_value = "8",
                      .min = 2,
                      .max = 1000}},
      .make = {}};
  return spheres;
}

const GridGenerator& generator_of(const std::string& kind) {
  if (kind == sphere_check().name) return sphere_check();
  if (const GridGenerator* generator = find_grid_generator(kind)) return *generator;
  std::vector<std::string> names;
  for (const GridGenerator& g : grid_generators()) names.push_back(g.name);
  names.push_back(sphere_check().name);
  const std::string hint = suggestion(kind, names);
  throw UsageError(fmt::format("grid: found \"{}\"{}; allowed: {}", kind,
                               hint.empty() ? "" : ", " + hint, listed(names)));
}

Parameters parameters_of(const GridGenerator& generator, const std::vector<std::string>& words) {
  Parameters parameters;
  std::vector<std::string> names;
  for (const ParameterInfo& info : generator.parameters) names.push_back(info.name);
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const std::string key = word.substr(0, equals);
    if (equals == std::string::npos)
      throw UsageError(fmt::format("grid {}: found \"{}\"; allowed: key=value, key one of {}",
                                   generator.name, word, listed(names)));
    const ParameterInfo* info = find(generator.parameters, key);
    if (!info) {
      const std::string hint = suggestion(key, names);
      throw UsageError(fmt::format("grid {}: key \"{}\": unknown{}; allowed: {}", generator.name,
                                   key, hint.empty() ? "" : ", " + hint, listed(names)));
    }
    try {
      parameters.set(key, parse_value(*info, word.substr(equals + 1)));
    } catch (const ParameterError& error) {
      throw UsageError(fmt::format("grid {}: {}", generator.name, error.what()));
    }
  }
  fill_defaults(generator.parameters, parameters);
  return parameters;
}

int list_kinds(const Options& options) {
  std::FILE* out = table_stream(options);
  Json answer = json_header("grid", options.seed, isa_of(options));
  answer["kinds"] = Json::array();
  std::vector<GridGenerator> kinds = grid_generators();
  kinds.push_back(sphere_check());
  for (const GridGenerator& g : kinds) {
    Json parameters = Json::array();
    if (!options.quiet) fmt::print(out, "{}", wrapped(g.name + ": ", g.doc, 4));
    for (const ParameterInfo& p : g.parameters) {
      if (!options.quiet)
        fmt::print(out, "{}",
                   wrapped(fmt::format("    {:<10} ", p.name),
                           fmt::format("[{}] {}; {}; default {}", p.unit, p.doc, allowed_values(p),
                                       p.default_value)));
      parameters.push_back({{"name", p.name},
                            {"unit", p.unit},
                            {"doc", p.doc},
                            {"allowed", allowed_values(p)},
                            {"default", p.default_value}});
    }
    answer["kinds"].push_back(
        {{"name", g.name}, {"doc", g.doc}, {"parameters", std::move(parameters)}});
  }
  write_json(answer, options.json);
  return kDone;
}

int check_spheres(const Options& options, const Parameters& parameters) {
  for (const char* key : {"voxels", "realisations"})
    if (parameters.number(key) != std::floor(parameters.number(key)))
      throw UsageError(fmt::format("grid spheres: key \"{}\": found {}; allowed: a whole number",
                                   key, to_text(parameters.number(key))));
  if (!options.output.empty())
    throw UsageError("grid spheres: found -o; allowed: nothing, it writes no file");
  const SphereBedCheck c =
      check_sphere_bed(parameters.number("radius"), parameters.number("packing"),
                       static_cast<int>(parameters.number("realisations")),
                       static_cast<int>(parameters.number("voxels")), options.seed);
  if (!options.quiet)
    fmt::print(table_stream(options),
               "{} spheres in {} beds, level sets of OpenVDB {}\n"
               "volume fraction {:.5f} +- {:.5f}; 1 - exp(-packing) = {:.5f}, {:.5f} through "
               "the blur\n"
               "area density    {:.5g} +- {:.2g} 1/mm; 3 packing / radius exp(-packing) = {:.5g}, "
               "{:.5g} through it\n",
               c.spheres, c.realisations, openvdb_version(), c.volume_fraction.value,
               c.volume_fraction.standard_error, c.expected_volume_fraction,
               c.blurred_volume_fraction, c.area_density.value, c.area_density.standard_error,
               c.expected_area_density, c.blurred_area_density);
  Json answer = json_header("grid", options.seed, isa_of(options));
  answer["kind"] = "spheres";
  Json given = Json::object();
  for (const auto& [key, value] : parameters.all()) given[key] = to_json(value);
  answer["parameters"] = std::move(given);
  const auto quantity = [](Estimate e, double expected, double blurred) {
    return Json{{"value", e.value},
                {"standard_error", e.standard_error},
                {"expected", expected},
                {"expected_through_blur", blurred}};
  };
  answer["volume_fraction"] =
      quantity(c.volume_fraction, c.expected_volume_fraction, c.blurred_volume_fraction);
  answer["area_density"] =
      quantity(c.area_density, c.expected_area_density, c.blurred_area_density);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace

int grid_command(const Options& options, const std::vector<std::string>& words) {
  if (words.empty()) return list_kinds(options);
  const GridGenerator& generator = generator_of(words[0]);
  const Parameters parameters = parameters_of(generator, {words.begin() + 1, words.end()});
  if (&generator == &sphere_check()) return check_spheres(options, parameters);
  if (options.output.empty())
    throw UsageError("grid: found no -o; allowed: -o FILE.vdb, the file to write");
  check_output_file(options.output);
  const GeneratedGrid made = [&] {
    try {
      return generator.make(parameters);
    } catch (const ParameterError& error) {
      throw UsageError(fmt::format("grid {}: {}", generator.name, error.what()));
    }
  }();
  const VoxelIndex n = made.voxels.extent().voxels;
  const Direction voxel{made.size_x / n[0], made.size_y / n[1], made.thickness / n[2]};
  write_vdb(options.output, made.voxels, voxel);
  // Text that is a stack file: what is said of the grid stands in comments. It is written for the
  // place where it goes: here, or beside the file of --json.
  const auto layer_in = [&](const std::filesystem::path& folder) {
    return fmt::format("[[layer]]\n{}thickness = {}\ngrid = {}\nsize = [{}, {}]\n", made.medium,
                       to_text(made.thickness),
                       to_text(ParameterValue(relative_to(options.output, folder).string())),
                       to_text(made.size_x), to_text(made.size_y));
  };
  const std::string layer = layer_in("");
  const Stack stack = parse_stack(layer, "<generated>", generator.name);
  const DensityGrid grid(stack.layers[0], std::make_shared<Voxels>(made.voxels));
  const LateralContrast contrast = lateral_contrast(grid);
  if (!options.quiet)
    fmt::print(
        table_stream(options), "{}{}",
        wrapped("# ", fmt::format("{}: {} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} mm,",
                                  options.output, n[0], n[1], n[2], voxel.x, voxel.y, voxel.z)) +
            fmt::format("# {} filled, lateral contrast {:.3f} between voxels, {:.3f} between "
                        "columns\n",
                        percent_text(contrast.filled), contrast.voxel, contrast.column),
        layer);
  Json answer = json_header("grid", options.seed, isa_of(options));
  answer["kind"] = generator.name;
  Json given = Json::object();
  for (const auto& [key, value] : parameters.all()) given[key] = to_json(value);
  answer["parameters"] = std::move(given);
  const std::filesystem::path place =
      options.json == "-" ? "" : std::filesystem::path(options.json).parent_path();
  answer["file"] = relative_to(options.output, place).string();
  answer["voxels"] = {n[0], n[1], n[2]};
  answer["voxel_size"] = {voxel.x, voxel.y, voxel.z};
  answer["filled"] = contrast.filled;
  answer["contrast_voxel"] = contrast.voxel;
  answer["contrast_column"] = contrast.column;
  answer["layer"] = layer_in(place);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
