#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/command/picture_options.h"
#include "compare/exchange/exported.h"
#include "compare/exchange/measured_comparison.h"
#include "compare/exchange/tensor_container.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/fit/least_squares.h"
#include "compare/nearest/nearest_models.h"
#include "compare/options/progress.h"
#include "compare/report/comparison_report.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
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

// `closed`: where the target is a closed form; else a file, or the stack.
TargetTruths target_of(const Options& options, const std::optional<BoundModel>& closed,
                       const Stack& stack, const RunMonitor& monitor) {
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
    const TruthRequest request = request_for(stem, options);
    const std::unique_ptr<Model> measured = read_brdf(read_format_file(text), text);
    return truths_of(*measured, measured_info("measured"), 3, request, monitor);
  }
  if (closed)
    return truths_of(*closed->model, *closed->info, closed->parameters.has_color() ? 3 : 1,
                     request_for(closed->info->name, options), monitor);
  GroundTruth truth(truth_request(options, stack), Estimator::analog, monitor);
  return truths_of(truth);
}

}  // namespace

int fit_models_command(const Options& options, const ClosedFormOptions& closed,
                       const std::vector<std::string>& pictures) {
  require_least_squares();
  const std::vector<ModelRequest> models = models_to_fit(options.models);
  (void)parametric_models(models, 1);
  const FitNorm norm = closed.norm == "log" ? FitNorm::logarithmic : FitNorm::relative;
  const FitSides sides = closed.sides == "reflect" ? FitSides::reflect : FitSides::all;
  const std::vector<PictureFormat> formats = picture_formats_of(pictures);
  catch_interrupts();
  const RunMonitor monitor = terminal_monitor(options);
  std::vector<std::filesystem::path> read = objects_among(models);
  std::optional<BoundModel> bound_target;
  Stack stack;
  if (is_lobe_file(options.stack) || is_measured_file(options.stack)) {
    read.emplace_back(options.stack);
  } else if (const auto request = model_target(options.stack)) {
    for (const std::filesystem::path& object : objects_among({*request})) read.push_back(object);
    bound_target = bind_model(*request, nullptr);
  } else {
    stack = stack_of(options);
  }
  const InputFiles inputs(stack, read);
  const TargetTruths target = target_of(options, bound_target, stack, monitor);
  std::optional<FolderLock> lock;
  if (!options.output.empty()) {
    make_output_folder(options.output);
    lock.emplace(options.output);
  }
  const NearestModels nearest =
      nearest_models(target, parametric_models(models, target.plan.channels), norm, sides, monitor);
  if (monitor.finished) monitor.finished();
  inputs.check();
  nlohmann::ordered_json answer = fit_json(target, nearest);
  add_files(answer, inputs);
  const std::string summary = fit_summary(target, nearest);
  if (!options.quiet) fmt::print(table_stream(options), "{}", summary);
  if (!options.output.empty()) {
    const std::string& folder = options.output;
    const std::vector<BoundModel> bound = bound_models(nearest);
    const StackComparison comparison = compare_with(target, bound);
    (void)write_comparison_files(folder, target.request, comparison, formats, inputs);
    nlohmann::ordered_json report = comparison_json(target.request, comparison);
    add_files(report, inputs);
    write_json(report, folder + "/report.json");
    write_json(answer, folder + "/fit.json");
    write_file(folder + "/summary.txt",
               summary + "\n" + comparison_summary(target.request, comparison));
    write_report_page(folder + "/report.html",
                      target.request.stack.name + ": the nearest closed forms", report,
                      comparison_details(comparison));
    if (!options.quiet)
      fmt::print(table_stream(options), "\nwrote {}/: report.html to look at, fit.json\n{}", folder,
                 absent_pictures_text());
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
