#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string_view>

#include "compare/exchange/lobe_archive.h"
#include "compare/exchange/npz_reader.h"
#include "compare/exchange/tensor_container.h"
#include "compare/library/reference_lobes.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

// What the names of energies begin with.
constexpr std::string_view kEnergy = "energy.";

NamedArray directions_array(const std::string& name, const std::vector<DirectionPair>& pairs,
                            Direction DirectionPair::*which) {
  NamedArray array{name, {pairs.size(), 3}, {}};
  for (const DirectionPair& pair : pairs) {
    const Direction w = pair.*which;
    array.values.insert(array.values.end(), {w.x, w.y, w.z});
  }
  return array;
}

NamedArray colors_array(const std::string& name, const std::vector<Rgb>& colors, int channels) {
  NamedArray array{name, {colors.size(), static_cast<std::size_t>(channels)}, {}};
  for (const Rgb& color : colors)
    for (int c = 0; c < channels; ++c) array.values.push_back(color[c]);
  return array;
}

}  // namespace

std::string reference_npz(const Reference& reference) {
  const LobeSet& set = reference.set;
  const std::vector<std::size_t> per_direction{set.directions.size(),
                                               static_cast<std::size_t>(set.channels)};
  std::vector<NamedArray> further{
      directions_array("points.wi", reference.pairs, &DirectionPair::wi),
      directions_array("points.wo", reference.pairs, &DirectionPair::wo),
      colors_array("points.f", reference.f, set.channels),
      colors_array("points.error", reference.f_error, set.channels)};
  for (const LobeBlock& block : set.energies) {
    const std::string name =
        std::string(kEnergy) + (block.side.empty() ? block.name : block.side + "." + block.name);
    further.push_back({name, per_direction, block.value});
    further.push_back({name + ".se", per_direction, block.standard_error});
  }
  if (!reference.unresolved.empty())
    further.push_back({"unresolved", per_direction, reference.unresolved});
  return lobe_npz(set, further);
}

Reference reference_of_npz(const std::string& bytes, const std::string& file) {
  const auto arrays = read_npz(bytes, file);
  Reference reference;
  reference.set = lobes_of_npz(arrays, file);
  const std::size_t channels = reference.set.channels;
  const auto at = [&](const std::string& name, std::size_t columns) -> const NpzArray& {
    const auto found = arrays.find(name);
    if (found == arrays.end() || found->second.shape.size() != 2 ||
        found->second.shape[1] != columns)
      throw FormatError(
          fmt::format("{}: found no array \"{}\" of {} columns; allowed: an entry of "
                      "lamella library",
                      file, name, columns));
    for (const double value : found->second.values)
      if (!std::isfinite(value))
        throw FormatError(
            fmt::format("{}: found a value of \"{}\" that is none; allowed: an entry "
                        "of lamella library",
                        file, name));
    return found->second;
  };
  const NpzArray &wi = at("points.wi", 3), &wo = at("points.wo", 3);
  const NpzArray &f = at("points.f", channels), &error = at("points.error", channels);
  const std::size_t count = wi.shape[0], directions = reference.set.directions.size();
  for (const NpzArray* array : {&wo, &f, &error})
    if (array->shape[0] != count)
      throw FormatError(
          fmt::format("{}: found {} values for {} points; allowed: an entry of lamella library",
                      file, array->shape[0], count));
  const auto direction = [](const NpzArray& array, std::size_t k) {
    return Direction{array.values[3 * k], array.values[3 * k + 1], array.values[3 * k + 2]};
  };
  const auto color = [&](const NpzArray& array, std::size_t k) {
    const double* v = array.values.data() + channels * k;
    return channels == 1 ? Rgb(v[0]) : Rgb(v[0], v[1], v[2]);
  };
  for (std::size_t k = 0; k < count; ++k) {
    reference.pairs.push_back({direction(wi, k), direction(wo, k)});
    reference.f.push_back(color(f, k));
    reference.f_error.push_back(color(error, k));
  }
  const auto per_direction = [&](const std::string& name) {
    const NpzArray& array = at(name, channels);
    if (array.shape[0] != directions)
      throw FormatError(fmt::format(
          "{}: found \"{}\" of another shape; allowed: an entry of lamella library", file, name));
    return array.values;
  };
  if (arrays.contains("unresolved")) reference.unresolved = per_direction("unresolved");
  for (const auto& [name, array] : arrays) {
    if (!name.starts_with(kEnergy) || name.ends_with(".se")) continue;
    const std::string of = name.substr(kEnergy.size());
    const std::size_t dot = of.find('.');
    reference.set.energies.push_back({dot == std::string::npos ? "" : of.substr(0, dot),
                                      dot == std::string::npos ? of : of.substr(dot + 1),
                                      per_direction(name), per_direction(name + ".se")});
  }
  return reference;
}

std::string reference_csv(const Reference& reference) {
  const int channels = reference.set.channels;
  std::string text = channels == 1 ? "mu_i,phi_i,mu_o,phi_o,f,error\n"
                                   : "mu_i,phi_i,mu_o,phi_o,f_r,f_g,f_b,error_r,error_g,error_b\n";
  const auto to = std::back_inserter(text);
  for (std::size_t k = 0; k < reference.pairs.size(); ++k) {
    const auto [wi, wo] = reference.pairs[k];
    fmt::format_to(to, "{:.17g},{:.17g},{:.17g},{:.17g}", wi.z, phi_degrees(wi), wo.z,
                   phi_degrees(wo));
    for (const Rgb& color : {reference.f[k], reference.f_error[k]})
      for (int c = 0; c < channels; ++c) fmt::format_to(to, ",{:.17g}", color[c]);
    text += '\n';
  }
  return text;
}

}  // namespace lamella
