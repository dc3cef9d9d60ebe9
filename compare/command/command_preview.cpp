#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "compare/command/command.h"
#include "compare/command/lamp_option.h"
#include "compare/command/picture_options.h"
#include "compare/command/texel_models.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/options/progress.h"
#include "compare/preview/preview_views.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/truth_request.h"
#include "compare/truth/texel_table.h"

namespace lamella {
namespace {

// --light and --environment.
PreviewLighting lighting_of(const Options& options) {
  const auto [theta, phi] = lamp_angles(options.light);
  return {theta, phi,
          options.environment == "uniform" ? Environment() : Environment(options.environment)};
}

}  // namespace

int preview_command(const Options& options, const std::vector<std::string>& pictures) {
  if (!options.shape.empty()) return preview_shape_command(options, pictures);
  for (const auto& [given, name] :
       {std::pair(options.seconds.has_value(), "--time"),
        std::pair(options.equal_time.has_value(), "--equal-time"),
        std::pair(options.samples_given, "--samples"), std::pair(options.table, "--table"),
        std::pair(options.white, "--white")})
    if (given) throw UsageError(fmt::format("{}: found no --shape; allowed: beside it", name));
  const StackOrMean asked = stack_or_mean_of(options);
  TruthRequest request = truth_request(options, asked.stack);
  request.texels = asked.texels;
  const Stack& stack = request.stack;
  check_preview("preview", stack, request.texels);
  const std::vector<PictureFormat> formats = picture_formats_of(pictures);
  std::vector<std::filesystem::path> read = objects_among(model_requests(options));
  if (options.environment != "uniform") read.emplace_back(options.environment);
  const InputFiles inputs(stack, read);
  const PreviewLighting lighting = lighting_of(options);
  const bool is_mean = !request.texels.empty();
  std::vector<BoundModel> models;
  if (!is_mean) models = fitted_models_for(model_requests(options), stack);
  const std::string folder = options.output.empty() ? stack.name + "-preview" : options.output;
  make_output_folder(folder);
  const FolderLock lock(folder);
  const RunMonitor monitor = terminal_monitor(options);
  TruthRequest of_truth = request;
  const auto& given = request.given;
  if (std::find(given.begin(), given.end(), WalkSetting::walks) == given.end())
    of_truth.effort.walks = kPreviewWalks;
  const TexelTable found = table_of_texels(of_truth, monitor.stop, monitor.solver);
  const LobeTable& table = found.table;
  if (monitor.finished) monitor.finished();
  // Of a map, truth and closed forms are means over the same texels.
  if (is_mean) models = models_of_texels(model_requests(options), found.texels, /*solved=*/true);
  std::FILE* out = table_stream(options);
  if (!options.quiet) {
    fmt::print(out, "{}", wrapped(stack.name + ": ", "truth by " + table.source(), 2));
    for (const BoundModel& model : models)
      fmt::print(out, "{}\n{}", model.info->name, told_parameters(model, 4));
    if (const std::string& taken = lighting.environment.source(); !taken.empty())
      fmt::print(out, "{}: {}\n", options.environment, taken);
  }
  const std::vector<PreviewResult> views =
      preview_views(table, models, lighting, options.size, &user_interrupt);
  inputs.check();
  write_preview_files(folder + "/", views, table, stack, lighting, formats, inputs);
  nlohmann::ordered_json answer = json_header("preview", request);
  answer["truth"] = table.source();
  answer["interrupted"] = user_interrupt.load();
  answer["views"] = to_json(views);
  add_files(answer, inputs);
  if (!options.quiet)
    fmt::print(out, "{}wrote {}/: an EXR{} per view\n{}", preview_table(views), folder,
               formats.empty() ? "" : fmt::format(" and a picture ({})", endings_text(formats)),
               absent_pictures_text());
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
