#include "analytic/catalogue/model_plugin.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>

#include "analytic/catalogue/lamella_model.h"
#include "phase/parameters/one_line.h"

namespace lamella {
namespace {

constexpr const char* kSymbol = "lamella_model_v1";
constexpr std::uint32_t kMostEntries = 64;

using Entry = lamella_model_v1_t;

// Relative error of a formula in single precision beyond its noise: four units in the last place.
constexpr double kSingleRounding = 4 * 0x1p-23;

bool is_name(const char* text) {
  if (!text || !*text) return false;
  for (const char* c = text; *c; ++c)
    if (!((*c >= 'a' && *c <= 'z') || (*c >= '0' && *c <= '9') || *c == '_')) return false;
  return true;
}

std::string found(const char* text) { return text ? fmt::format("\"{}\"", text) : "nothing"; }

// The entry of a shared object, checked before any member is used.
void check(const std::string& path, const Entry& e) {
  const auto refuse = [&](const std::string& what, const std::string& was, const char* allowed) {
    throw ModelPluginError(fmt::format("{}: {}: found {}; allowed: {}", path, what, was, allowed));
  };
  if (e.version != LAMELLA_MODEL_V1)
    refuse("version", fmt::format("{}", e.version), "1 (LAMELLA_MODEL_V1)");
  constexpr const char* kNames = "lower-case letters, digits and _";
  if (!is_name(e.name)) refuse("name", found(e.name), kNames);
  if (!e.eval) refuse("eval", "nothing", "a function");
  if (!e.sample != !e.pdf)
    refuse(e.sample ? "pdf" : "sample", "nothing", "both sample and pdf, or neither");
  if (e.parameter_count > kMostEntries || (e.parameter_count && !e.parameters))
    refuse("parameters", fmt::format("{}", e.parameter_count), "up to 64 entries");
  if (e.lobe_count < 1 || e.lobe_count > kMostEntries || !e.lobes)
    refuse("lobes", fmt::format("{}", e.lobes ? e.lobe_count : 0), "1 to 64 entries");
  for (std::uint32_t k = 0; k < e.parameter_count; ++k) {
    const lamella_parameter_v1_t& p = e.parameters[k];
    if (!is_name(p.name)) refuse(fmt::format("parameter {}: name", k), found(p.name), kNames);
    const std::string what = fmt::format("parameter \"{}\"", p.name);
    if (p.channels != 1 && p.channels != 3)
      refuse(what + ": channels", fmt::format("{}", p.channels), "1 or 3");
    if (!(p.min <= p.default_value && p.default_value <= p.max))
      refuse(what, fmt::format("min {}, default {}, max {}", p.min, p.default_value, p.max),
             "min <= default <= max");
  }
  for (std::uint32_t k = 0; k < e.lobe_count; ++k) {
    const lamella_lobe_v1_t& l = e.lobes[k];
    if (!is_name(l.name)) refuse(fmt::format("lobe {}: name", k), found(l.name), kNames);
    if (l.order < 0 || l.order > 4)
      refuse(fmt::format("lobe \"{}\": order", l.name), fmt::format("{}", l.order), "0 to 4");
  }
}

class PluginModel final : public Model {
 public:
  PluginModel(const Entry& entry, std::string path, const std::vector<double>& values)
      : Model(static_cast<int>(entry.lobe_count)), entry_(entry), path_(std::move(path)) {
    if (!entry_.create) return;
    state_ = entry_.create(values.data());
    if (!state_)
      throw ModelPluginError(
          fmt::format("{}: create: found NULL for these parameters; allowed: a state", path_));
  }
  ~PluginModel() override {
    if (state_ && entry_.destroy) entry_.destroy(state_);
  }
  PluginModel(const PluginModel&) = delete;
  PluginModel& operator=(const PluginModel&) = delete;

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    std::vector<Rgb> lobes(entry_.lobe_count);
    eval_lobes(wi, wo, lobes);
    return lobes[static_cast<std::size_t>(lobe)];
  }

  void eval_lobes(Direction wi, Direction wo, std::span<Rgb> values) const override {
    const DirectionPair pair{wi, wo};
    const std::vector<double> raw = evaluated({&pair, 1});
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = {raw[3 * k], raw[3 * k + 1], raw[3 * k + 2]};
  }

  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override {
    const DirectionPair pair{wi, wo};
    Rgb value;
    eval({&pair, 1}, {&value, 1}, Isa::scalar);
    return value;
  }

  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values,
            Isa /*isa*/) const override {
    const std::vector<double> raw = evaluated(pairs);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      Rgb sum;
      for (std::size_t lobe = 0; lobe < entry_.lobe_count; ++lobe) {
        const double* v = raw.data() + 3 * (pairs.size() * lobe + k);
        sum += Rgb(v[0], v[1], v[2]);
      }
      values[k] = sum;
    }
  }

  /// Rounding of constants and parameters in single precision errs alike in all values: no
  /// difference of neighbours shows it.
  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    AlbedoEstimate albedo = Model::albedo_with_error(wi);
    if (single_precision_)
      for (int c = 0; c < 3; ++c)
        albedo.error[c] = std::max(albedo.error[c], kSingleRounding * albedo.value[c]);
    return albedo;
  }

  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (!entry_.sample) return Model::sample(wo, u1, u2, u3);
    const double o[3] = {wo.x, wo.y, wo.z}, u[3] = {u1, u2, u3};
    double i[3] = {0, 0, 0};
    if (!entry_.sample(state_, o, u, i)) return std::nullopt;
    const Direction wi{i[0], i[1], i[2]};
    if (!(std::abs(dot(wi, wi) - 1) < 1e-9))
      throw std::domain_error(fmt::format(
          "{}: sample: found ({}, {}, {}) for w_o = ({}, {}, {}); allowed: a unit vector", path_,
          wi.x, wi.y, wi.z, wo.x, wo.y, wo.z));
    return wi;
  }

  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (!entry_.pdf) return Model::pdf(wi, wo);
    const double i[3] = {wi.x, wi.y, wi.z}, o[3] = {wo.x, wo.y, wo.z};
    const double density = entry_.pdf(state_, i, o);
    if (!(density >= 0)) refuse("pdf", density, {wi, wo});
    return density;
  }

 private:
  [[noreturn]] void refuse(const std::string& what, double value, const DirectionPair& p) const {
    throw std::domain_error(fmt::format(
        "{}: {}: found {} at w_i = ({}, {}, {}), w_o = ({}, {}, {}); allowed: a finite number that "
        "is not negative",
        path_, what, value, p.wi.x, p.wi.y, p.wi.z, p.wo.x, p.wo.y, p.wo.z));
  }

  /// The values of all lobes, as the interface has them, checked.
  [[nodiscard]] std::vector<double> evaluated(std::span<const DirectionPair> pairs) const {
    const std::size_t n = pairs.size();
    std::vector<double> wi(3 * n), wo(3 * n);
    const auto put = [](std::vector<double>& list, std::size_t k, Direction w) {
      w = with_grazing_limit(w);
      list[3 * k] = w.x;
      list[3 * k + 1] = w.y;
      list[3 * k + 2] = w.z;
    };
    for (std::size_t k = 0; k < n; ++k) {
      put(wi, k, pairs[k].wi);
      put(wo, k, pairs[k].wo);
    }
    if (n == 0) return {};
    // What eval does not write is found.
    std::vector<double> values(3 * n * entry_.lobe_count, std::nan(""));
    entry_.eval(state_, n, wi.data(), wo.data(), values.data());
    for (std::size_t k = 0; k < values.size(); ++k)
      if (!(values[k] >= 0) || std::isinf(values[k]))
        refuse(fmt::format("lobe \"{}\"", entry_.lobes[k / (3 * n)].name), values[k],
               pairs[k / 3 % n]);
    if (single_precision_ && !std::all_of(values.begin(), values.end(), [](double v) {
          return static_cast<double>(static_cast<float>(v)) == v;
        }))
      single_precision_ = false;
    return values;
  }

  const Entry& entry_;
  std::string path_;
  void* state_ = nullptr;
  /// Whether every value so far was one of single precision.
  mutable std::atomic<bool> single_precision_ = true;
};

std::string text_of(const char* text) { return text ? text : ""; }

ModelInfo info_of(const Entry& e, const std::string& path) {
  ModelInfo info;
  info.name = e.name;
  info.doc = text_of(e.doc);
  info.source = text_of(e.source);
  info.reciprocal = e.reciprocal != 0;
  info.transmits = e.transmits != 0;
  for (std::uint32_t k = 0; k < e.parameter_count; ++k) {
    const lamella_parameter_v1_t& p = e.parameters[k];
    info.parameters.push_back(
        {.name = p.name,
         .kind = p.channels == 3 ? ParameterKind::color : ParameterKind::number,
         .unit = p.unit ? p.unit : "1",
         .doc = text_of(p.doc),
         .default_value = to_text(p.default_value),
         .min = p.min,
         .max = p.max});
  }
  constexpr std::array kOrder{Order::all, Order::one, Order::two, Order::three, Order::four_plus};
  for (std::uint32_t k = 0; k < e.lobe_count; ++k)
    info.lobes.push_back({e.lobes[k].name, text_of(e.lobes[k].doc),
                          kOrder.at(static_cast<std::size_t>(e.lobes[k].order))});
  info.make = [&e, path, list = info.parameters](const Parameters& p, const Stack*) {
    std::vector<double> values;
    for (const ParameterInfo& parameter : list)
      if (parameter.kind == ParameterKind::color) {
        const Rgb c = p.color(parameter.name);
        values.insert(values.end(), {c.r, c.g, c.b});
      } else {
        values.push_back(p.number(parameter.name));
      }
    return std::make_unique<PluginModel>(e, path, values);
  };
  return info;
}

}  // namespace

bool is_plugin_path(std::string_view name) {
  return name.find('/') != std::string_view::npos || name.ends_with(".so");
}

const ModelInfo& load_model_plugin(const std::string& path) {
  static std::mutex mutex;
  static std::map<std::string, ModelInfo> loaded;
  const std::scoped_lock lock(mutex);
  const auto known = loaded.find(path);
  if (known != loaded.end()) return known->second;
  // Without a slash dlopen would look in the system's folders.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  // Opening a pipe would wait for a writer.
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
    throw ModelPluginError(fmt::format("{}: is no regular file; allowed: a shared object", path));
  void* object = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!object)
    throw ModelPluginError(fmt::format("{}: cannot be loaded: {}; allowed: a shared object", path,
                                       one_line(dlerror())));
  const auto* entry = static_cast<const Entry*>(dlsym(object, kSymbol));
  if (!entry) {
    dlclose(object);
    throw ModelPluginError(fmt::format(
        "{}: symbol \"{}\": found nothing; allowed: a constant of type lamella_model_v1_t", path,
        kSymbol));
  }
  check(path, *entry);
  return loaded.emplace(path, info_of(*entry, path)).first->second;
}

const ModelInfo* find_or_load_model(const std::string& name) {
  return is_plugin_path(name) ? &load_model_plugin(name) : find_model(name);
}

}  // namespace lamella
