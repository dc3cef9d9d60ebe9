#include "compare/command/fit_target_source.h"

#include <fmt/format.h>

#include "analytic/catalogue/model_plugin.h"
#include "compare/exchange/exported.h"
#include "compare/exchange/measured_comparison.h"
#include "compare/exchange/tensor_container.h"
#include "compare/request/errors.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

// A target that is a closed form: NAME[,key=value...] of no built-in stack.
std::optional<ModelRequest> model_target(const std::string& text) {
  const std::string name = text.substr(0, text.find(','));
  for (const BuiltinStack& stack : builtin_stacks())
    if (stack.name == name) return std::nullopt;
  if (text.ends_with(".toml") || !(find_model(name) || is_plugin_path(name))) return std::nullopt;
  return parse_model_request(text);
}

// The request of a target that is no stack.
TruthRequest request_for(const std::string& name, const Options& options) {
  if (!options.walk_settings.empty() || options.estimator != "auto")
    throw UsageError(fmt::format(
        "fit {}: found {}; allowed: of a stack alone", options.stack,
        options.estimator != "auto" ? "--estimator" : to_text(options.walk_settings.front())));
  TruthRequest request;
  request.stack.name = name;
  request.directions = incident_directions(options, Stack{});
  request.cells = parse_grid(options.grid);
  request.seed = options.seed;
  request.isa = isa_of(options);
  return request;
}

bool is_lobe_file(const std::string& text) { return text.ends_with(".exr"); }

}  // namespace

FitTargetSource fit_target_source(const Options& options) {
  FitTargetSource source;
  if (is_lobe_file(options.stack) || is_measured_file(options.stack)) {
    source.files.emplace_back(options.stack);
  } else if (const auto request = model_target(options.stack)) {
    source.files = objects_among({*request});
    source.model = bind_model(*request, nullptr);
  } else {
    source.stack = stack_of(options);
  }
  return source;
}

bool has_other_directions(const Options& options) { return !is_lobe_file(options.stack); }

TargetTruths target_of(const Options& options, const FitTargetSource& source,
                       const RunMonitor& monitor, const std::vector<Direction>& others) {
  const auto along = [&](TruthRequest request) {
    if (!others.empty()) request.directions = others;
    return request;
  };
  const std::optional<BoundModel>& closed = source.model;
  const std::string& text = options.stack;
  const std::string stem = std::filesystem::path(text).stem().string();
  if (is_lobe_file(text)) {
    if (!options.incident.empty() || options.grid != Options{}.grid)
      throw UsageError(
          fmt::format("fit {}: found {}; allowed: neither --wi nor --grid, as a file "
                      "of lobes has its own",
                      text, options.incident.empty() ? "--grid" : "--wi"));
    (void)request_for(stem, options);
    TargetTruths target = truths_of(read_lobes(text), stem);
    target.request.isa = isa_of(options);
    target.request.seed = options.seed;
    return target;
  }
  if (is_measured_file(text)) {
    const TruthRequest request = along(request_for(stem, options));
    const std::unique_ptr<Model> measured = read_brdf(read_format_file(text), text);
    return truths_of(*measured, measured_info("measured"), 3, request, monitor);
  }
  if (closed)
    return truths_of(*closed->model, *closed->info, closed->parameters.has_color() ? 3 : 1,
                     along(request_for(closed->info->name, options)), monitor);
  GroundTruth truth(along(truth_request(options, source.stack)), Estimator::analog, monitor);
  return truths_of(truth);
}

}  // namespace lamella
