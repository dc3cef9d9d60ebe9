#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "compare/command/command.h"
#include "compare/command/fit_folder.h"
#include "compare/command/fit_target_source.h"
#include "compare/command/picture_options.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/nearest/held_out.h"
#include "compare/nearest/stack_fit.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/substrate_model.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {

int fit_stack_command(const Options& options, const ClosedFormOptions& closed,
                      const std::vector<std::string>& pictures) {
  const bool to_file = options.output.ends_with(".toml"),
             to_folder = !options.output.empty() && !to_file;
  if (!pictures.empty() && !to_folder)
    throw UsageError("--pictures: found no folder beside it; allowed: with -o FOLDER");
  const std::vector<PictureFormat> formats = picture_formats_of(pictures);
  if (to_file) check_output_file(options.output);
  if (options.stack == "-" && closed.stack == "-")
    throw UsageError("--stack: found - twice; allowed: stdin for one stack");
  const FitTargetSource source = fit_target_source(options);
  // The place is the target's, or where that is no stack, the fitted stack's.
  const bool has_place = !options.at.empty() && (source.model || !source.files.empty());
  const Stack stack =
      has_place ? stack_of(options, closed.stack) : with_surface_model(load_stack(closed.stack));
  (void)parametric_stack(stack, closed.vary, 1);
  const RunMonitor monitor = terminal_monitor(options);
  const InputFiles inputs(source.stack, source.files), of_stack(stack);
  Options of_target = options;
  if (source.model || !source.files.empty()) {
    // What is asked of walks and solver is asked of the fitted stack.
    of_target.walk_settings.clear();
    of_target.estimator = Options{}.estimator;
  }
  const TargetTruths target = target_of(of_target, source, monitor);
  std::optional<FolderLock> lock;
  if (to_folder) {
    make_output_folder(options.output);
    lock.emplace(options.output);
  }
  Options how = options;
  how.incident.clear();
  const ParametricStack varied = parametric_stack(stack, closed.vary, target.plan.channels);
  const TruthRequest of_fitted = truth_request(how, stack);
  NearestModels nearest = nearest_stack(
      target, varied, of_fitted, closed.norm == "log" ? FitNorm::logarithmic : FitNorm::relative,
      closed.sides == "reflect" ? FitSides::reflect : FitSides::all, monitor);
  if (has_other_directions(options) && !monitor.is_stopped())
    if (const auto others = held_out_directions(target.request.directions); !others.empty())
      judge_stack_held_out(nearest, target_of(of_target, source, monitor, others), varied,
                           of_fitted, monitor);
  if (monitor.finished) monitor.finished();
  inputs.check();
  of_stack.check();
  nlohmann::ordered_json answer = fit_json(target, nearest);
  add_files(answer, inputs);
  const std::string summary = fit_summary(target, nearest);
  if (!options.quiet) fmt::print(table_stream(options), "{}", summary);
  const ModelFit& fit = nearest.fits.front();
  if (to_file) {
    write_file(options.output, fit.stack);
    if (!options.quiet) fmt::print(table_stream(options), "\nwrote {}\n", options.output);
  }
  if (to_folder) {
    ModelInfo info;
    const BoundModel model = fitted_stack_model(fit, info);
    write_file(options.output + "/stack.toml", fit.stack);
    write_fit_folder(options, {target, compare_with_stack(target, fit, model), inputs, formats},
                     answer, summary, "the nearest stack");
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
