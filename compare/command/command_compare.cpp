#include <fmt/format.h>

#include <algorithm>

#include "analytic/catalogue/model_plugin.h"
#include "analytic/layered/spongecake.h"
#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/command/picture_options.h"
#include "compare/command/texel_models.h"
#include "compare/exchange/measured_comparison.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/stack_comparison.h"
#include "compare/maps/mean_model.h"
#include "compare/options/progress.h"
#include "compare/preview/preview_views.h"
#include "compare/report/comparison_report.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/report/report_page.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/run_monitor.h"
#include "compare/request/stack_parameters.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "compare/truth/texel_table.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// What a preview costs is not what the comparison may cost: the solver where it applies, whatever
// counted the lobes, else walks enough for a picture.
TruthRequest preview_request(const TruthRequest& request) {
  TruthRequest preview = request;
  preview.estimator.reset();
  preview.given.clear();
  preview.effort.walks = std::min(request.effort.walks, kPreviewWalks);
  return preview;
}

// Beyond --max-error.
bool is_too_far(const StackComparison& comparison, const Options& options) {
  return options.max_error && worst_relative_rmse(comparison) > *options.max_error;
}

}  // namespace

CommandAnswer compare_answer(const Options& options, const Stack& stack,
                             const RunMonitor& monitor) {
  const TruthRequest request = truth_request(options, stack);
  GroundTruth truth(request, Estimator::analog, monitor);
  const std::vector<BoundModel> models = fitted_models_for(model_requests(options), stack);
  const StackComparison comparison = compare_stack(truth, models);
  return {comparison_json(request, comparison), is_too_far(comparison, options) ? kFailed : kDone};
}

namespace {

int compare_run(const DividedRun& run, const RunMonitor& monitor) {
  const Options& options = run.options;
  const TruthRequest request = request_of(run);
  const Stack& stack = request.stack;
  const std::vector<PictureFormat> formats = picture_formats_of(run.pictures);
  if (options.preview) check_preview("compare --preview", stack, run.texels);
  GroundTruth truth(request, Estimator::analog, monitor);
  const std::vector<BoundModel> models =
      run.texels.empty() ? fitted_models_for(model_requests(options), stack)
                         : models_of_texels(model_requests(options), run.texels,
                                            truth.estimator() == Estimator::deterministic);
  const InputFiles inputs(stack, objects_of(models));
  const std::string folder = options.output.empty() ? stack.name + "-compare" : options.output;
  make_output_folder(folder);
  const FolderLock lock(folder);

  const StackComparison comparison = compare_stack(truth, models);
  inputs.check();
  Json answer = comparison_json(request, comparison), details = comparison_details(comparison);
  add_files(answer, inputs);
  std::string summary = comparison_summary(request, comparison);
  const int drawn = write_comparison_files(folder, request, comparison, formats, inputs);
  if (options.preview && !user_interrupt) {
    const TexelTable of_texels =
        table_of_texels(preview_request(request), monitor.stop, monitor.solver);
    const LobeTable& lobes = of_texels.table;
    if (monitor.finished) monitor.finished();
    // Of a map, truth and closed forms are means over the same texels.
    std::vector<BoundModel> means;
    if (!run.texels.empty())
      means = models_of_texels(model_requests(options), of_texels.texels, /*solved=*/true);
    const PreviewLighting lighting;
    const std::vector<PreviewResult> views = preview_views(
        lobes, run.texels.empty() ? models : means, lighting, options.size, &user_interrupt);
    write_preview_files(folder + "/preview_", views, lobes, named_for_image(request, folder).stack,
                        lighting, formats, inputs);
    answer["previews"] = to_json(views);
    if (!formats.empty()) details["previews"] = preview_page_details(views, lobes, lighting);
    summary += fmt::format("\npreview: truth by {}\n{}", lobes.source(), preview_table(views));
  }
  write_json(answer, folder + "/report.json");
  write_file(folder + "/summary.txt", summary);
  write_report_page(folder + "/report.html", stack.name + ": closed forms against ground truth",
                    answer, details);
  if (!options.quiet) {
    std::FILE* out = table_stream(options);
    fmt::print(out, "{}", summary);
    if (models.empty()) fmt::print(out, "no closed form applies to this stack (see --model)\n");
    if (user_interrupt) fmt::print(out, "interrupted: what was done until then\n");
    fmt::print(
        out, "\n{}{}",
        wrapped(fmt::format("wrote {}/: ", folder),
                fmt::format("report.html to look at, truth.exr, an EXR per model, report.json, "
                            "summary.txt{}{}",
                            options.preview ? ", previews (preview_*)" : "",
                            formats.empty() ? ""
                                            : fmt::format(" and {} error maps ({})", drawn,
                                                          endings_text(formats))),
                2),
        absent_pictures_text());
  }
  write_json(answer, options.json);
  return is_too_far(comparison, options) ? kFailed : kDone;
}

void check_comparison(const DividedRun& run) {
  check_walks_are_given(truth_request(run.options, run.stack));
  for (const ModelRequest& request : model_requests(run.options))
    if (is_plugin_path(request.name))
      throw UsageError(fmt::format(
          "--shard: found --model {}, a shared object, which a part file cannot hold; allowed: "
          "closed forms that lamella models lists",
          request.name));
  for (const ModelRequest& request : model_requests(run.options))
    check_request(without_stack_key(request, run.stack));
}

}  // namespace

const DividedCommand& compare_divided() {
  static const DividedCommand command{"compare", "FOLDER", check_comparison, find_truths,
                                      compare_run};
  return command;
}

int compare_command(const Options& options, const std::vector<std::string>& pictures) {
  if (!options.truth_model.empty() || is_measured_file(options.stack)) {
    if (!options.shard.empty() || !options.checkpoint.empty() || started_ranks())
      throw UsageError(
          fmt::format("--shard, --checkpoint, mpirun: found {}, which takes no walks; allowed: a "
                      "stack",
                      options.truth_model.empty() ? "a measured material" : "--truth"));
    return compare_with_model_command(options, pictures);
  }
  StackOrMean found = stack_or_mean_of(options);
  return do_divided(compare_divided(), {.command = "compare",
                                        .options = options,
                                        .stack = std::move(found.stack),
                                        .pictures = pictures,
                                        .texels = std::move(found.texels)});
}

}  // namespace lamella
