#include "phase/stack_file.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

namespace lamella {
namespace {

const ParameterInfo kAlbedo{.name = "albedo",
                            .kind = ParameterKind::color,
                            .unit = "1",
                            .doc = "single-scattering albedo",
                            .default_value = "1",
                            .min = 0,
                            .max = 1};
const ParameterInfo kThickness{
    .name = "thickness", .unit = "mm", .doc = "inf for a half space", .min = 0};
const ParameterInfo kDensity{.name = "density",
                             .unit = "1/mm",
                             .doc = "multiplies sigma",
                             .default_value = "1",
                             .min = 0,
                             .max_open = true};
const ParameterInfo kBsdf{.name = "bsdf",
                          .kind = ParameterKind::choice,
                          .unit = "1",
                          .doc = "lambert, or black (albedo 0)",
                          .default_value = "lambert",
                          .choices = {"lambert", "black"}};

class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  [[noreturn]] void fail(const toml::source_region& where, const std::string& message) const {
    throw StackFileError(fmt::format("{}:{}: {}", file_, where.begin.line, message));
  }

  Stack read(const toml::table& root, std::string name) const {
    Stack stack;
    stack.name = std::move(name);
    for (const auto& [key, node] : root)
      if (key != "layer" && key != "substrate")
        fail(key.source(), unknown_key(key.str(), {"layer", "substrate"}, "the stack"));
    const toml::node* layers = root.get("layer");
    if (!layers)
      throw StackFileError(fmt::format(
          "{}:1: key \"layer\": found nothing; allowed: one or more [[layer]] tables", file_));
    const toml::array* array = layers->as_array();
    if (!array || array->empty() || !array->is_homogeneous(toml::node_type::table))
      fail(layers->source(), fmt::format("key \"layer\": found {}; allowed: one or more [[layer]] "
                                         "tables",
                                         described(*layers)));
    int index = 0;
    for (const auto& node : *array) {
      stack.layers.push_back(read_layer(*node.as_table(), index));
      const Layer& layer = stack.layers.back();
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
      stack.substrate = read_substrate(*table);
    }
    return stack;
  }

 private:
  static std::string described(const toml::node& node) {
    if (const auto* s = node.as_string()) return '"' + s->get() + '"';
    if (node.is_table()) return "a table";
    if (node.is_array()) return "an array";
    if (const auto number = node.value<double>()) return to_text(*number);
    if (const auto flag = node.value<bool>()) return *flag ? "true" : "false";
    return "a date or time";
  }

  static std::string unknown_key(std::string_view key, const std::vector<std::string>& allowed,
                                 const std::string& where) {
    const std::string hint = suggestion(key, allowed);
    return fmt::format("key \"{}\": unknown in {}{}; allowed: {}", key, where,
                       hint.empty() ? "" : ", " + hint, listed(allowed));
  }

  static std::optional<ParameterValue> to_value(const toml::node& node) {
    if (const auto* s = node.as_string()) return s->get();
    if (node.is_number()) return *node.value<double>();
    const toml::array* array = node.as_array();
    if (!array) return std::nullopt;
    std::vector<double> numbers;
    for (const auto& element : *array) {
      if (!element.is_number()) return std::nullopt;
      numbers.push_back(*element.value<double>());
    }
    return numbers;
  }

  // Reads those keys of the table that `infos` names; every other key but those in `also` is an
  // error.
  Parameters read_keys(const toml::table& table, const std::vector<ParameterInfo>& infos,
                       const std::vector<std::string>& also, const std::string& where) const {
    Parameters parameters;
    std::vector<std::string> allowed = also;
    for (const ParameterInfo& info : infos) allowed.push_back(info.name);
    for (const auto& [key, node] : table) {
      const ParameterInfo* info = find(infos, key.str());
      if (!info) {
        if (std::find(also.begin(), also.end(), key.str()) != also.end()) continue;
        fail(key.source(), unknown_key(key.str(), allowed, where));
      }
      const auto value = to_value(node);
      if (!value)
        fail(node.source(), fmt::format("{}: key \"{}\": found {}; allowed: {}", where, info->name,
                                        described(node), allowed_values(*info)));
      try {
        parameters.set(info->name, checked(*info, *value));
      } catch (const ParameterError& error) {
        fail(node.source(), fmt::format("{}: {}", where, error.what()));
      }
    }
    fill_defaults(infos, parameters);
    return parameters;
  }

  Layer read_layer(const toml::table& table, int index) const {
    const std::string where = fmt::format("layer {}", index);
    std::vector<std::string> names;
    for (const MediumInfo& info : media()) names.push_back(info.name);
    const toml::node* medium = table.get("medium");
    if (!medium)
      fail(table.source(), fmt::format("{}: key \"medium\": found nothing; allowed: one of {}",
                                       where, listed(names)));
    const toml::value<std::string>* name = medium->as_string();
    const MediumInfo* info = name ? find_medium(name->get()) : nullptr;
    if (!info) {
      const std::string hint = name ? suggestion(name->get(), names) : "";
      fail(medium->source(),
           fmt::format("{}: key \"medium\": found {}{}; allowed: one of {}", where,
                       described(*medium), hint.empty() ? "" : " (" + hint + ")", listed(names)));
    }
    std::vector<ParameterInfo> infos = info->parameters;
    infos.insert(infos.end(), {kAlbedo, kThickness, kDensity});
    Parameters all = read_keys(table, infos, {"medium"}, where);
    if (!all.has("thickness"))
      fail(table.source(), fmt::format("{}: key \"thickness\": found nothing; allowed: {}", where,
                                       allowed_values(kThickness)));
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
    Parameters own;
    for (const ParameterInfo& parameter : info->parameters)
      if (all.has(parameter.name)) own.set(parameter.name, all.at(parameter.name));
    try {
      Medium built = info->make(own);
      const Rgb f0 = own.has("f0") ? own.color("f0") : Rgb(1);
      return {info->name, std::move(own), std::move(built), all.color("albedo"),
              f0,         thickness,      density};
    } catch (const ParameterError& error) {
      const toml::node* node = table.get(error.key);
      fail(node ? node->source() : table.source(), fmt::format("{}: {}", where, error.what()));
    }
  }

  Substrate read_substrate(const toml::table& table) const {
    const bool has_albedo = table.contains("albedo");
    const Parameters p = read_keys(table, {kBsdf, kAlbedo}, {}, "substrate");
    if (p.choice("bsdf") == "lambert") return {p.color("albedo")};
    if (has_albedo && p.color("albedo").max() > 0)
      fail(table.get("albedo")->source(),
           "substrate: key \"albedo\": found a positive albedo of a black substrate; allowed: 0");
    return {Rgb(0)};
  }

  std::string file_;
};

}  // namespace

Stack parse_stack(std::string_view text, const std::string& file, std::string name) {
  try {
    const toml::table root = toml::parse(text, file);
    return Reader(file).read(root, std::move(name));
  } catch (const toml::parse_error& error) {
    throw StackFileError(fmt::format("{}:{}: not valid TOML: {}", file, error.source().begin.line,
                                     error.description()));
  }
}

std::string to_toml(const Stack& stack) {
  std::string text;
  for (const Layer& layer : stack.layers) {
    text += fmt::format("[[layer]]\nmedium = \"{}\"\n", layer.medium_name);
    for (const auto& [key, value] : layer.parameters.all())
      text += fmt::format("{} = {}\n", key, to_text(value));
    text += fmt::format("albedo = {}\nthickness = {}\ndensity = {}\n\n", to_text(layer.albedo),
                        to_text(layer.thickness), to_text(layer.density));
  }
  if (stack.substrate)
    text += fmt::format("[substrate]\nbsdf = \"lambert\"\nalbedo = {}\n",
                        to_text(ParameterValue(stack.substrate->albedo)));
  return text;
}

}  // namespace lamella
