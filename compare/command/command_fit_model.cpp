#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "compare/command/command.h"
#include "compare/command/fit_folder.h"
#include "compare/command/fit_target_source.h"
#include "compare/command/picture_options.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/fit/least_squares.h"
#include "compare/nearest/held_out.h"
#include "compare/nearest/nearest_models.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"

namespace lamella {
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
  const FitTargetSource source = fit_target_source(options);
  if (source.model || !source.files.empty()) refuse_place(options, options.stack);
  std::vector<std::filesystem::path> read = objects_among(models);
  read.insert(read.end(), source.files.begin(), source.files.end());
  const InputFiles inputs(source.stack, read);
  const TargetTruths target = target_of(options, source, monitor);
  std::optional<FolderLock> lock;
  if (!options.output.empty()) {
    make_output_folder(options.output);
    lock.emplace(options.output);
  }
  NearestModels nearest =
      nearest_models(target, parametric_models(models, target.plan.channels), norm, sides, monitor);
  if (has_other_directions(options) && !monitor.is_stopped())
    if (const auto others = held_out_directions(target.request.directions); !others.empty())
      judge_held_out(nearest, target_of(options, source, monitor, others));
  if (monitor.finished) monitor.finished();
  inputs.check();
  nlohmann::ordered_json answer = fit_json(target, nearest);
  add_files(answer, inputs);
  const std::string summary = fit_summary(target, nearest);
  if (!options.quiet) fmt::print(table_stream(options), "{}", summary);
  if (!options.output.empty()) {
    const std::vector<BoundModel> bound = bound_models(nearest);
    write_fit_folder(options, {target, compare_with(target, bound), inputs, formats}, answer,
                     summary, "the nearest closed forms");
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
