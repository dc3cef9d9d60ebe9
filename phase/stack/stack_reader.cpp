#include "phase/stack/stack_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "phase/medium/media.h"
#include "phase/parameters/one_line.h"
#include "phase/stack/grid_keys.h"
#include "phase/stack/key_reader.h"
#include "phase/stack/layer_keys.h"
#include "phase/stack/stack_file_error.h"

namespace lamella {
namespace {

const ParameterInfo kBsdf{.name = "bsdf",
                          .kind = ParameterKind::choice,
                          .unit = "1",
                          .doc = "lambert, black (albedo 0), conductor, or a closed form",
                          .default_value = "lambert",
                          .choices = {"lambert", "black"}};

class Reader : KeyReader {
 public:
  using KeyReader::KeyReader;

  Stack read(const toml::table& root, std::string name) const {
    Stack stack;
    stack.name = std::move(name);
    for (const auto& [key, node] : root)
      if (key != "layer" && key != "substrate")
        fail(key.source(), unknown_key(key.str(), {"layer", "substrate"}, "the stack"));
    const toml::node* layers = root.get("layer");
    // A surface may stand alone.
    static const toml::array nothing;
    if (!layers && !root.get("substrate"))
      throw StackFileError(fmt::format(
          "{}:1: key \"layer\": found nothing; allowed: one or more [[layer]] tables, or a "
          "[substrate] alone",
          file()));
    const toml::array* array = layers ? layers->as_array() : &nothing;
    if (!array || (layers && array->empty()) ||
        !(array->empty() || array->is_homogeneous(toml::node_type::table)))
      fail(layers->source(), fmt::format("key \"layer\": found {}; allowed: one or more [[layer]] "
                                         "tables",
                                         described(*layers)));
    int index = 0;
    for (const auto& node : *array) {
      stack.layers.push_back(read_layer(*node.as_table(), index));
      const Layer& layer = stack.layers.back();
      if (layer.grains && array->size() > 1)
        fail(
            node.as_table()->get("medium")->source(),
            fmt::format("layer {}: key \"medium\": found \"{}\" among {} layers; allowed: explicit "
                        "geometry as the only layer, over a [substrate] or none",
                        index, layer.medium_name, array->size()));
      if (layer.interface && (stack.has_grid() || stack.grains()))
        fail(
            node.as_table()->get("interface")->source(),
            fmt::format("layer {}: key \"interface\": found \"{}\" beside {}; allowed: layers "
                        "without grids, whose walk knows no interfaces",
                        index, layer.medium_name, stack.grains() ? "explicit geometry" : "a grid"));
      if (layer.grid && stack.layers.size() > 1 &&
          std::any_of(stack.layers.begin(), stack.layers.end(),
                      [](const Layer& l) { return l.interface.has_value(); }))
        fail(node.as_table()->get("grid")->source(),
             fmt::format("layer {}: key \"grid\": found {} beside an interface; allowed: layers "
                         "without grids, whose walk knows no interfaces",
                         index, described(*node.as_table()->get("grid"))));
      if (std::isinf(layer.thickness) && node.as_table() != array->back().as_table())
        fail(array->get(index)->as_table()->get("thickness")->source(),
             fmt::format("layer {}: key \"thickness\": found inf; allowed: a finite number in "
                         "[0, inf), as only the last layer may be infinite",
                         index));
      ++index;
    }
    if (const toml::node* substrate = root.get("substrate")) {
      const toml::table* table = substrate->as_table();
      if (!table)
        fail(substrate->source(), fmt::format("key \"substrate\": found {}; allowed: a "
                                              "[substrate] table",
                                              described(*substrate)));
      if (stack.is_half_space())
        fail(substrate->source(),
             "key \"substrate\": found a substrate below an infinite layer; allowed: a substrate "
             "below layers of finite thickness, or none");
      stack.substrate = read_substrate(*table, stack);
      const bool black = stack.substrate->model.empty() && stack.substrate->albedo.max() == 0;
      if (stack.grains() && stack.grains()->is_height_field() && !black)
        fail(substrate->source(),
             "key \"substrate\": found a substrate below a height_field, which no light passes; "
             "allowed: none");
    }
    // Micrograins are halves: there is always a plane that they stand on. Nothing passes a height
    // field.
    if (stack.grains() && !stack.grains()->is_bed() && !stack.substrate)
      stack.substrate = Substrate{};
    return stack;
  }

 private:
  Layer read_layer(const toml::table& table, int index) const {
    const std::string where = fmt::format("layer {}", index);
    if (const toml::node* interface = table.get("interface")) {
      if (const toml::node* medium = table.get("medium"))
        fail(medium->source(), fmt::format("{}: key \"medium\": found {} beside \"interface\"; "
                                           "allowed: one of the two",
                                           where, described(*medium)));
      return read_interface(table, *interface, where);
    }
    std::vector<std::string> names;
    for (const MediumInfo& info : media()) names.push_back(info.name);
    for (const GeometryInfo& info : geometries()) names.push_back(info.name);
    const toml::node* medium = table.get("medium");
    if (!medium)
      fail(table.source(), fmt::format("{}: key \"medium\": found nothing; allowed: one of {} (or "
                                       "\"interface\")",
                                       where, listed(names)));
    const toml::value<std::string>* name = medium->as_string();
    if (const GeometryInfo* geometry = name ? find_geometry(name->get()) : nullptr)
      return read_geometry(table, *geometry, where);
    const MediumInfo* info = name ? find_medium(name->get()) : nullptr;
    if (!info) {
      const std::string hint = name ? suggestion(name->get(), names) : "";
      fail(medium->source(),
           fmt::format("{}: key \"medium\": found {}{}; allowed: one of {}", where,
                       described(*medium), hint.empty() ? "" : " (" + hint + ")", listed(names)));
    }
    std::vector<ParameterInfo> infos = info->parameters;
    infos.insert(infos.end(), {albedo_key(), thickness_key(), density_key()});
    std::vector<std::string> others{"medium"};
    others.insert(others.end(), grid_keys().begin(), grid_keys().end());
    Parameters all = read_keys(table, infos, others, where);
    if (!all.has("thickness"))
      fail(table.source(), fmt::format("{}: key \"thickness\": found nothing; allowed: {}", where,
                                       allowed_values(thickness_key())));
    const double thickness = all.number("thickness"), density = all.number("density");
    if (std::isinf(thickness) && density == 0)
      fail(table.get("density")->source(),
           fmt::format("{}: key \"density\": found 0 with an infinite thickness; allowed: a number "
                       "in (0, inf)",
                       where));
    if (std::isfinite(thickness) && std::isinf(thickness * density))
      fail(table.get("density")->source(),
           fmt::format(
               "{}: key \"density\": found {}, an optical depth beyond all numbers; allowed: "
               "a finite product with the thickness {}",
               where, to_text(density), to_text(thickness)));
    const std::optional<GridReference> grid = read_grid(*this, table, where, thickness);
    Parameters own;
    for (const ParameterInfo& parameter : info->parameters)
      if (all.has(parameter.name)) own.set(parameter.name, all.at(parameter.name));
    try {
      Medium built = info->make(own);
      const Rgb f0 = own.has("f0") ? own.color("f0") : Rgb(1);
      return {info->name, std::move(own), std::move(built), all.color("albedo"),
              f0,         thickness,      density,          grid,
              {}};
    } catch (const ParameterError& error) {
      const toml::node* node = table.get(error.key);
      fail(node ? node->source() : table.source(), fmt::format("{}: {}", where, error.what()));
    }
  }

  // A boundary of zero thickness: none of a medium's keys is taken.
  Layer read_interface(const toml::table& table, const toml::node& node,
                       const std::string& where) const {
    std::vector<std::string> names;
    for (const InterfaceInfo& info : interfaces()) names.push_back(info.name);
    const auto* name = node.as_string();
    const InterfaceInfo* info = name ? find_interface(name->get()) : nullptr;
    if (!info) {
      const std::string hint = name ? suggestion(name->get(), names) : "";
      fail(node.source(),
           fmt::format("{}: key \"interface\": found {}{}; allowed: one of {}", where,
                       described(node), hint.empty() ? "" : " (" + hint + ")", listed(names)));
    }
    Layer layer{.medium_name = info->name,
                .parameters = read_keys(table, info->parameters, {"interface"},
                                        where + fmt::format(", a {} interface", info->name)),
                .medium = HenyeyGreenstein{0},
                .thickness = 0,
                .density = 0};
    try {
      layer.interface = info->make(layer.parameters);
    } catch (const ParameterError& error) {
      const toml::node* at = table.get(error.key);
      fail(at ? at->source() : table.source(), fmt::format("{}: {}", where, error.what()));
    }
    return layer;
  }

  Layer read_geometry(const toml::table& table, const GeometryInfo& info,
                      const std::string& where) const {
    std::vector<ParameterInfo> infos = info.parameters;
    infos.push_back(albedo_key());
    Parameters all = read_keys(table, infos, {"medium"}, where);
    Layer layer{.medium_name = info.name,
                .parameters = {},
                .medium = HenyeyGreenstein{0},
                .albedo = all.color("albedo")};
    for (const ParameterInfo& parameter : info.parameters)
      if (all.has(parameter.name)) layer.parameters.set(parameter.name, all.at(parameter.name));
    try {
      layer.grains = make_geometry(info, layer.parameters);
    } catch (const ParameterError& error) {
      const toml::node* node = table.get(error.key);
      fail(node ? node->source() : table.source(), fmt::format("{}: {}", where, error.what()));
    }
    if (layer.parameters.has("f0")) layer.f0 = layer.parameters.color("f0");
    layer.thickness = layer.grains->thickness;
    return layer;
  }

  // The surface below: Lambert's, black, a conductor, or any closed form, whose name and keys
  // another room knows. Beds of grains and grids walk above Lambert's alone.
  Substrate read_substrate(const toml::table& table, const Stack& stack) const {
    const auto name = table["bsdf"].value<std::string>();
    const bool simple = !name || *name == "lambert" || *name == "black";
    const bool bed = stack.grains() && stack.grains()->is_bed();
    if (name && name->empty())
      fail(table.get("bsdf")->source(),
           "substrate: key \"bsdf\": found an empty word; allowed: a closed form's name");
    if (!simple && (bed || stack.has_grid()))
      fail(table.get("bsdf")->source(),
           fmt::format("substrate: key \"bsdf\": found \"{}\" below {}; allowed: lambert, black",
                       *name, bed ? "a bed of grains" : "a grid"));
    if (name && *name == kConductor && !stack.grains()) return read_conductor(table, stack);
    if (!simple) {
      Substrate substrate{.model = *name};
      for (const auto& [key, node] : table) {
        substrate.where.emplace(key.str(), fmt::format("{}:{}", file(), key.source().begin.line));
        if (key == "bsdf") continue;
        const auto value = to_value(node);
        if (!value)
          fail(node.source(), fmt::format("substrate: key \"{}\": found {}; allowed: a number, a "
                                          "colour or a word",
                                          key.str(), described(node)));
        substrate.parameters.set(std::string(key.str()), *value);
      }
      return substrate;
    }
    const bool has_albedo = table.contains("albedo");
    const Parameters p = read_keys(table, {kBsdf, albedo_key()}, {}, "substrate");
    if (p.choice("bsdf") == "lambert") return {.albedo = p.color("albedo")};
    if (has_albedo && p.color("albedo").max() > 0)
      fail(table.get("albedo")->source(),
           "substrate: key \"albedo\": found a positive albedo of a black substrate; allowed: 0");
    return {};
  }

  Substrate read_conductor(const toml::table& table, const Stack& stack) const {
    Substrate substrate{
        .model = kConductor,
        .parameters = read_keys(table, conductor_parameters(), {"bsdf"}, "substrate")};
    try {
      substrate.law = std::make_shared<Conductor>(
          conductor_setting(substrate.parameters, stack.index_of(stack.layers.size())));
    } catch (const ParameterError& error) {
      const toml::node* node = table.get(error.key);
      fail(node ? node->source() : table.source(), fmt::format("substrate: {}", error.what()));
    }
    return substrate;
  }
};

}  // namespace

toml::table parse_toml(std::string_view text, const std::string& file) {
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw StackFileError(fmt::format("{}:{}: not valid TOML: {}", file, error.source().begin.line,
                                     one_line(error.description())));
  }
}

Stack read_stack(const toml::table& root, const std::string& file, std::string name) {
  return Reader(file).read(root, std::move(name));
}

}  // namespace lamella
