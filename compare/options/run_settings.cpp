#include "compare/options/run_settings.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <concepts>
#include <utility>

#include "compare/request/errors.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostTexts = 100000;

// One list of the options serves writing and reading.
template <class Io, class AnyOptions>
void each_setting(Io& io, AnyOptions& o) {
  io("incident", o.incident);
  io("incident_law", o.incident_law);
  io("walks", o.walks);
  io("target_error", o.target_error);
  io("time", o.seconds);
  io("max_order", o.max_order);
  io("thin_from", o.thin_from);
  io("sampling", o.sampling);
  io("walk_order_1", o.walk_order_1);
  io("walk_options", o.walk_settings);
  io("tolerance", o.tolerance);
  io("grid", o.grid);
  io("estimator", o.estimator);
  io("seed", o.seed);
  io("isa", o.isa);
  io("models", o.models);
  io("max_error", o.max_error);
  io("strict", o.strict);
  io("as_is", o.as_is);
  io("preview", o.preview);
  io("size", o.size);
  io("sets", o.sets);
  io("of", o.of);
  io("lobes", o.lobes);
  io("design", o.design);
}

struct Write {
  Json json = Json::object();

  template <class T>
  void operator()(const char* key, const T& value) {
    json[key] = value;
  }
  template <class T>
  void operator()(const char* key, const std::optional<T>& value) {
    json[key] = value ? Json(*value) : Json();
  }
  void operator()(const char* key, const std::vector<WalkSetting>& value) {
    json[key] = Json::array();
    for (const WalkSetting setting : value) json[key].push_back(to_text(setting));
  }
};

struct Read {
  const Json& json;
  const std::string& where;
  std::size_t count = 0;

  [[noreturn]] void refuse(const char* key) const {
    throw UsageError(fmt::format("{}: setting \"{}\": found {}; allowed: what lamella writes",
                                 where, key, json.contains(key) ? json[key].dump() : "nothing"));
  }
  void require(bool fits, const char* key) const {
    if (!fits) refuse(key);
  }
  const Json& at(const char* key) {
    ++count;
    const auto found = json.find(key);
    require(found != json.end(), key);
    return *found;
  }
  void read(const char* key, const Json& from, std::string& value) const {
    require(from.is_string(), key);
    value = from.get<std::string>();
  }
  void read(const char* key, const Json& from, bool& value) const {
    require(from.is_boolean(), key);
    value = from.get<bool>();
  }
  void read(const char* key, const Json& from, double& value) const {
    require(from.is_number(), key);
    value = from.get<double>();
  }
  template <std::integral T>
  void read(const char* key, const Json& from, T& value) const {
    require(from.is_number_unsigned() && std::in_range<T>(from.get<std::uint64_t>()), key);
    value = from.get<T>();
  }
  template <class T>
  void operator()(const char* key, T& value) {
    read(key, at(key), value);
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value) {
    const Json& from = at(key);
    value.reset();
    if (!from.is_null()) read(key, from, value.emplace());
  }
  void operator()(const char* key, std::vector<std::string>& value) {
    const Json& from = at(key);
    require(from.is_array() && from.size() <= kMostTexts, key);
    for (const Json& one : from) read(key, one, value.emplace_back());
  }
  void operator()(const char* key, std::vector<WalkSetting>& value) {
    std::vector<std::string> words;
    (*this)(key, words);
    for (const std::string& word : words) {
      bool known = false;
      for (const WalkSetting setting :
           {WalkSetting::walks, WalkSetting::target_error, WalkSetting::max_order,
            WalkSetting::thin_from, WalkSetting::seconds})
        if (to_text(setting) == word) {
          value.push_back(setting);
          known = true;
        }
      require(known, key);
    }
  }
};

}  // namespace

Json settings_json(const Options& options) {
  Write io;
  each_setting(io, options);
  // Which set `auto` stands for is the machine's.
  io.json["isa"] = to_text(isa_of(options));
  return io.json;
}

Options options_from(const Json& settings, const std::string& where) {
  Options options;
  Read io{settings, where};
  if (!settings.is_object())
    throw UsageError(fmt::format("{}: found no settings; allowed: what lamella writes", where));
  each_setting(io, options);
  if (settings.size() != io.count)
    throw UsageError(
        fmt::format("{}: found {} settings; allowed: {}", where, settings.size(), io.count));
  const auto positive = [](const std::optional<double>& x) {
    return !x || (*x > 0 && std::isfinite(*x));
  };
  // The ranges of the command line.
  io.require(options.walks >= kBatches && options.walks <= 1000000000000000, "walks");
  io.require(!options.max_order ||
                 (*options.max_order >= 1 && *options.max_order <= std::uint64_t{1} << 62),
             "max_order");
  io.require(!options.thin_from || *options.thin_from == 0 ||
                 (*options.thin_from <= 1 << 20 && std::has_single_bit(*options.thin_from)),
             "thin_from");
  io.require(sampling_from(options.sampling).has_value(), "sampling");
  io.require(positive(options.tolerance), "tolerance");
  io.require(positive(options.target_error), "target_error");
  io.require(positive(options.seconds), "time");
  io.require(!options.max_error || *options.max_error >= 0, "max_error");
  io.require(options.size >= 16 && options.size <= 2048, "size");
  io.require(options.of == "compare" || options.of == "furnace", "of");
  io.require(options.isa != "auto", "isa");
  return options;
}

}  // namespace lamella
