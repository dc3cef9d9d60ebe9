#include "compare/nearest/free_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "analytic/catalogue/model_plugin.h"
#include "compare/request/errors.h"
#include "compare/request/split_text.h"

namespace lamella {
namespace {

constexpr double kDecades = 1e3;      // of a logarithmic range, at least
constexpr double kOpenMargin = 1e-6;  // of a range, away from an end that is not in it

// Kept at its default unless it is asked for.
bool is_setting(const std::string& name) {
  return name == "walks" || name == "seed" || name == "terms" || name.ends_with("_y") ||
         name.ends_with("ior");
}

bool has_range(const ParameterInfo& p) {
  const bool kind = p.kind == ParameterKind::number || p.kind == ParameterKind::color ||
                    p.kind == ParameterKind::one_or_two;
  return kind && std::isfinite(p.min) && std::isfinite(p.max) && p.max > p.min;
}

FreeNumber free_number(const ParameterInfo& p, int channel, const Parameters& defaults) {
  FreeNumber free{.key = p.name,
                  .channel = channel,
                  .is_color = p.kind == ParameterKind::color,
                  .low = p.min,
                  .high = p.max};
  const double margin = kOpenMargin * (p.max - p.min);
  if (p.min_open) free.low += margin;
  if (p.max_open) free.high -= margin;
  free.is_logarithmic = free.low > 0 && free.high / free.low > kDecades;
  free.standard = 0.5;
  if (defaults.has(p.name)) {
    const ParameterValue& value = defaults.at(p.name);
    if (const double* number = std::get_if<double>(&value)) free.standard = free.scaled(*number);
    if (const Rgb* color = std::get_if<Rgb>(&value))
      free.standard = free.scaled((*color)[std::max(channel, 0)]);
  }
  return free;
}

}  // namespace

bool has_coat_tables(const std::string& name) {
  return name == "coated" || name == "openpbr_diffuse";
}

double FreeNumber::value(double x) const {
  // Both ends exactly.
  if (x <= 0) return low;
  if (x >= 1) return high;
  return is_logarithmic ? low * std::pow(high / low, x) : low + (high - low) * x;
}

double FreeNumber::scaled(double v) const {
  const double x =
      is_logarithmic ? std::log(v / low) / std::log(high / low) : (v - low) / (high - low);
  return std::isfinite(x) ? std::clamp(x, 0.0, 1.0) : 0.0;
}

double FreeNumber::slope(double x) const {
  return is_logarithmic ? value(x) * std::log(high / low) : high - low;
}

std::string FreeNumber::name() const {
  return channel < 0 ? key : fmt::format("{}.{}", key, "rgb"[channel]);
}

Parameters ParametricModel::parameters(std::span<const double> scaled) const {
  Parameters all = fixed;
  std::map<std::string, Rgb> colors;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const double value = free[k].value(scaled[k]);
    if (!free[k].is_color)
      all.set(free[k].key, value);
    else if (free[k].channel < 0)
      all.set(free[k].key, Rgb(value));
    else
      colors[free[k].key][free[k].channel] = value;
  }
  for (const auto& [key, color] : colors) all.set(key, color);
  return all;
}

std::unique_ptr<Model> ParametricModel::make(std::span<const double> scaled) const {
  return info->make(parameters(scaled), nullptr);
}

ParametricModel parametric_model(const ModelInfo& info, const ModelRequest& request, int channels) {
  if (info.needs_stack)
    throw UsageError(fmt::format(
        "fit: found model \"{}\", which is built from a stack; allowed: a closed form with "
        "parameters of its own",
        info.name));
  ParametricModel model;
  model.info = &info;
  model.request = request;
  std::vector<std::string> freed;
  std::erase_if(model.request.values, [&](const auto& v) {
    if (v.second == "free") freed.push_back(v.first);
    return v.second == "free";
  });
  const std::vector<ParameterInfo> infos = parameters_of(info, model.request);
  model.fixed = read_parameters(request.name, infos, model.request.values);
  for (const std::string& key : freed) {
    std::vector<std::string> names;
    for (const ParameterInfo& p : infos)
      if (has_range(p)) names.push_back(p.name);
    if (std::find(names.begin(), names.end(), key) == names.end())
      throw UsageError(fmt::format("{}: key \"{}\": found \"free\"; allowed of: {}", request.name,
                                   key, names.empty() ? "none" : listed(names)));
  }
  for (const ParameterInfo& p : infos) {
    const bool given = std::any_of(model.request.values.begin(), model.request.values.end(),
                                   [&](const auto& v) { return v.first == p.name; });
    const bool asked = std::find(freed.begin(), freed.end(), p.name) != freed.end();
    if (!given && !has_range(p) && p.default_value.empty())
      throw UsageError(fmt::format("{}: key \"{}\": found nothing; allowed: {}", request.name,
                                   p.name, allowed_values(p)));
    if (given || !has_range(p) || (is_setting(p.name) && !asked)) continue;
    const bool per_channel = p.kind == ParameterKind::color && channels == 3;
    for (int c = per_channel ? 0 : -1; c < (per_channel ? 3 : 0); ++c)
      model.free.push_back(free_number(p, c, model.fixed));
  }
  return model;
}

std::vector<ModelRequest> models_to_fit(const std::vector<std::string>& texts) {
  std::vector<ModelRequest> requests;
  for (const std::string& text : texts) {
    std::vector<std::string> words;
    for (const std::string& part : split_text(text, ',')) {
      // What follows a value may belong to it: albedo=0.9,0.5,0.2.
      const bool is_word = part.find('=') == std::string::npos;
      const bool starts =
          words.empty() || part == "all" || find_model(part) ||
          (is_word && (is_plugin_path(part) || words.back().find('=') == std::string::npos));
      if (starts)
        words.push_back(part);
      else
        words.back() += "," + part;
    }
    for (const std::string& word : words) {
      if (word != "all") {
        requests.push_back(parse_model_request(word));
        continue;
      }
      for (const ModelInfo& info : models()) {
        const bool random = find(info.parameters, "walks") != nullptr;
        if (!info.needs_stack && !random) requests.push_back({info.name, {}});
      }
    }
  }
  return requests;
}

}  // namespace lamella
