#include <fmt/format.h>

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <filesystem>
#include <optional>

#include "analytic/catalogue/model_plugin.h"
#include "analytic/model/stochastic_model.h"
#include "compare/command/command.h"
#include "compare/exchange/exported.h"
#include "compare/exchange/measured_comparison.h"
#include "compare/exchange/tensor_container.h"
#include "compare/fit/albedo_inversion.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/model_request.h"
#include "compare/request/run_monitor.h"
#include "compare/request/substrate_model.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kModelTolerance = 1e-9;
constexpr CellGrid kTotalsGrid{4, 8, false};

// A colour as it is seen: from one direction, or (Bond) under light from everywhere.
struct Lighting {
  std::vector<std::pair<Direction, double>> directions;  // with weights that sum to 1
};

Lighting lighting_of(const Options& options, const ClosedFormOptions& closed, const Stack* stack) {
  if (closed.bond) {
    Lighting all;
    using Rule = boost::math::quadrature::gauss<double, 8>;
    for (std::size_t k = 0; k < Rule::abscissa().size(); ++k)
      for (const double sign : {-1.0, 1.0}) {
        const double mu = (1 + sign * Rule::abscissa()[k]) / 2;
        all.directions.emplace_back(direction_from_mu_phi(mu, 0), mu * Rule::weights()[k]);
      }
    return all;
  }
  if (options.incident.empty()) return {{{Direction{0, 0, 1}, 1.0}}};
  if (options.incident.size() > 1)
    throw UsageError(
        fmt::format("--wi: found {} directions; allowed: one", options.incident.size()));
  return {{{incident_directions(options, stack ? *stack : Stack{}).front(), 1.0}}};
}

// The colour that is to be had, and the key that it was given by: a value, or the file of a
// measured material whose colour it is.
struct Target {
  Rgb color;
  std::string key;
  std::string file{};
};

// A directional albedo, as "albedo" or by its older name "color".
Target take_color(KeyValues& values, const std::string& what) {
  ParameterInfo info{
      .name = "albedo", .kind = ParameterKind::color, .unit = "1", .doc = "", .min = 0, .max = 1};
  std::optional<Target> target;
  for (auto it = values.begin(); it != values.end();) {
    if (it->first != "albedo" && it->first != "color") {
      ++it;
      continue;
    }
    if (target)
      throw UsageError(fmt::format("{}: key \"{}\": found {} as a second colour; allowed: one",
                                   what, it->first, it->second));
    info.name = it->first;
    if (is_measured_file(it->second)) {
      target = {Rgb(), it->first, it->second};
      it = values.erase(it);
      continue;
    }
    try {
      target = {std::get<Rgb>(parse_value(info, it->second)), it->first};
    } catch (const ParameterError& error) {
      throw UsageError(fmt::format("{}: {}", what, error.what()));
    }
    it = values.erase(it);
  }
  if (!target)
    throw UsageError(fmt::format(
        "{}: key \"albedo\": found nothing; allowed: {}, or a measured material (.binary, .bsdf)",
        what, allowed_values(info)));
  return *target;
}

// Of a measured material.
Rgb color_of(const std::string& file, const Lighting& lighting) {
  const std::unique_ptr<Model> material = read_brdf(read_format_file(file), file);
  Rgb sum;
  for (const auto& [wi, weight] : lighting.directions)
    sum += weight * material->albedo_with_error(with_grazing_limit(wi)).value;
  return sum;
}

std::string text_of(Rgb c) {
  std::string text = to_text(ParameterValue(c));
  std::erase_if(text, [](char x) { return x == '[' || x == ']' || x == ' '; });
  return text;
}

// A word that is neither a model nor a stack may be a mistyped one of both.
void refuse_unknown_word(const std::string& what) {
  if (what == "-" || what.find_first_of("./") != std::string::npos || std::filesystem::exists(what))
    return;
  std::vector<std::string> names;
  for (const BuiltinStack& stack : builtin_stacks()) {
    if (stack.name == what) return;
    names.push_back(stack.name);
  }
  for (const ModelInfo& info : models()) names.push_back(info.name);
  const std::string hint = suggestion(what, names);
  throw UsageError(fmt::format(
      "invert: found \"{}\"{}; allowed: a model (lamella models lists them), a TOML file, - for "
      "stdin, or a built-in stack (lamella stacks lists them)",
      what, hint.empty() ? "" : ", " + hint));
}

struct CsvAnswer {
  AlbedoInversion inversion;
  Rgb standard_error;  // of the albedo, from a simulation's noise or the error of a quadrature
};

CsvAnswer invert_model(const std::string& name, const ModelInfo& info, const KeyValues& values,
                       Rgb target, const Options& options, const ClosedFormOptions& closed) {
  if (!find(info.parameters, "albedo"))
    throw UsageError(fmt::format(
        "invert: found \"{}\", which has no albedo; allowed: a model with one, or a stack", name));
  const Lighting lighting = lighting_of(options, closed, nullptr);
  Rgb error;  // of the last colour
  const auto color = [&](Rgb albedo) {
    ModelRequest request{name, values};
    request.values.emplace_back("albedo", text_of(albedo));
    const BoundModel bound = bind_model(request, nullptr);
    const bool stochastic = dynamic_cast<const StochasticModel*>(bound.model.get()) != nullptr;
    Rgb sum;
    error = Rgb();
    for (const auto& [wi, weight] : lighting.directions) {
      const AlbedoEstimate seen = bound.model->albedo_with_error(with_grazing_limit(wi));
      sum += weight * seen.value;
      // The random numbers of a stochastic model are the same for every albedo.
      if (!stochastic) error += weight * seen.error;
    }
    return sum;
  };
  // Closer than the error of the colours is no use: in single precision they have noise.
  (void)color(Rgb(1));
  CsvAnswer answer{invert_albedo(color, target, std::max(kModelTolerance, error.max())), Rgb()};
  for (int c = 0; c < 3; ++c)
    if (error[c] > kModelTolerance)
      answer.standard_error[c] = error[c] / std::abs(answer.inversion.slope[c]);
  return answer;
}

CsvAnswer invert_stack(const Stack& stack, Rgb target, const Options& options,
                       const ClosedFormOptions& closed) {
  const Lighting lighting = lighting_of(options, closed, &stack);
  TruthRequest request = truth_request(options, stack);
  request.cells = kTotalsGrid;
  request.directions.clear();
  // Rounded like directions that are typed.
  for (const auto& [wi, weight] : lighting.directions)
    request.directions.push_back(direction_from_degrees(theta_degrees(wi), phi_degrees(wi)));
  const RunMonitor monitor = terminal_monitor(options);
  Rgb variance;
  // Of the first albedo whose walks the clock ended, if any: the others have as many.
  std::vector<std::optional<std::uint64_t>> walks(lighting.directions.size());
  const auto color = [&](Rgb albedo) {
    for (Layer& layer : request.stack.layers) layer.albedo = albedo;
    // Walks are the same for every albedo: the colour is smooth in it but for what roulette ends.
    GroundTruth truth(request, Estimator::analog, monitor);
    Rgb sum;
    variance = Rgb();
    for (std::size_t k = 0; k < lighting.directions.size(); ++k) {
      const RunResult run = truth.find(k, walks[k]).run;
      if (!run.is_bounded()) walks[k] = run.walks;
      const double weight = lighting.directions[k].second;
      for (int c = 0; c < 3; ++c) {
        const Estimate e = run.reflected.total[run.channels == 3 ? c : 0];
        sum[c] += weight * e.value;
        variance[c] += std::pow(weight * e.standard_error, 2);
      }
    }
    return sum;
  };
  // Closer than the noise is no use.
  CsvAnswer answer{invert_albedo(color, target, 1e-5), Rgb()};
  for (int c = 0; c < 3; ++c)
    answer.standard_error[c] = std::sqrt(variance[c]) / answer.inversion.slope[c];
  return answer;
}

}  // namespace

int invert_command(const Options& options, const ClosedFormOptions& closed,
                   const std::vector<std::string>& words) {
  const std::string& what = words[0];
  KeyValues values = parse_model_words(words).values;
  Target target = take_color(values, what);
  const ModelInfo* info =
      what.ends_with(".so") || find_model(what) ? find_or_load_model(what) : nullptr;
  std::vector<std::filesystem::path> measured, read = objects_among({{what, {}}});
  if (!target.file.empty()) measured.emplace_back(target.file);
  read.insert(read.end(), measured.begin(), measured.end());
  InputFiles inputs(Stack{}, read);
  if (!target.file.empty())
    target.color = color_of(target.file, lighting_of(options, closed, nullptr));
  CsvAnswer answer;
  try {
    if (info) {
      answer = invert_model(what, *info, values, target.color, options, closed);
    } else {
      refuse_unknown_word(what);
      const Stack stack = with_surface_model(load_stack(what));
      if (!values.empty())
        throw UsageError(
            fmt::format("{}: key \"{}\": unknown; allowed: albedo", what, values[0].first));
      inputs = InputFiles(stack, measured);
      answer = invert_stack(stack, target.color, options, closed);
    }
  } catch (const UnreachableColor& error) {
    throw UsageError(fmt::format("{}: key \"{}\": {}", what, target.key, error.what()));
  }
  const AlbedoInversion& found = answer.inversion;
  if (!options.quiet) {
    std::FILE* out = table_stream(options);
    fmt::print(out, "{}: albedo {} gives {}{} after {} evaluations\n", what, text_of(found.albedo),
               text_of(found.reached),
               answer.standard_error.max() > 0
                   ? fmt::format(", +- {} of the albedo", text_of(answer.standard_error))
                   : "",
               found.evaluations);
  }
  const auto list = [](Rgb c) { return Json{c.r, c.g, c.b}; };
  inputs.check();
  Json json = json_header("invert", options.seed, isa_of(options));
  add_files(json, inputs);
  json["what"] = what;
  json["color"] = list(target.color);
  json["albedo"] = list(found.albedo);
  json["reached"] = list(found.reached);
  json["albedo_standard_error"] = list(answer.standard_error);
  json["evaluations"] = found.evaluations;
  write_json(json, options.json);
  return kDone;
}

}  // namespace lamella
