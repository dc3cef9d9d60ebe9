#include <fmt/format.h>

#include <filesystem>

#include "compare/command/command.h"
#include "compare/command/picture_options.h"
#include "compare/exchange/exported.h"
#include "compare/exchange/measured_comparison.h"
#include "compare/exchange/tensor_container.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/comparison_report.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"

namespace lamella {

namespace {

// The material that closed forms are compared with: a file's, or a closed form.
struct TruthModel {
  std::unique_ptr<Model> measured{};
  BoundModel closed{};
  std::string name, what;
  [[nodiscard]] const Model& model() const { return measured ? *measured : *closed.model; }
  [[nodiscard]] ModelInfo info() const {
    return measured ? measured_info("measured") : *closed.info;
  }
};

TruthModel truth_model(const Options& options) {
  TruthModel truth;
  if (options.truth_model.empty()) {
    truth.measured = read_brdf(read_format_file(options.stack), options.stack);
    truth.name = std::filesystem::path(options.stack).stem().string();
    truth.what = "a measured material";
    return truth;
  }
  if (!options.stack.empty())
    throw UsageError(fmt::format(
        "compare: found both the stack {} and --truth; allowed: one of them", options.stack));
  truth.closed = bind_model(parse_model_request(options.truth_model), nullptr);
  truth.name = truth.closed.info->name;
  truth.what = options.truth_model;
  return truth;
}

}  // namespace

int compare_with_model_command(const Options& options, const std::vector<std::string>& pictures) {
  const char* material =
      options.truth_model.empty() ? "a measured material" : "a closed form as the truth";
  if (options.preview)
    throw UsageError(fmt::format("compare --preview: found {}; allowed: a stack", material));
  const std::vector<ModelRequest> requests = model_requests(options);
  if (requests.empty())
    throw UsageError(
        fmt::format("compare: found no --model; allowed: one or more, as nothing says which apply "
                    "to {}",
                    material));
  const std::vector<PictureFormat> formats = picture_formats_of(pictures);
  TruthRequest request;
  const TruthModel truth = truth_model(options);
  request.stack.name = truth.name;
  request.directions = incident_directions(options, Stack{});
  request.cells = parse_grid(options.grid);
  request.seed = options.seed;
  request.isa = isa_of(options);
  std::vector<BoundModel> models;
  for (const ModelRequest& model : requests) models.push_back(bind_model(model, nullptr));
  std::vector<std::filesystem::path> read = objects_of(models);
  if (truth.measured) read.emplace_back(options.stack);
  if (!truth.closed.object.empty()) read.emplace_back(truth.closed.object);
  const InputFiles inputs(Stack{}, read);
  const std::string folder =
      options.output.empty() ? request.stack.name + "-compare" : options.output;
  make_output_folder(folder);
  const FolderLock lock(folder);
  const StackComparison comparison = compare_with_model({truth.model(), truth.info(), truth.what},
                                                        request, models, terminal_monitor(options));
  inputs.check();
  nlohmann::ordered_json answer = comparison_json(request, comparison);
  add_files(answer, inputs);
  (void)write_comparison_files(folder, request, comparison, formats, inputs);
  const std::string summary = comparison_summary(request, comparison);
  write_json(answer, folder + "/report.json");
  write_file(folder + "/summary.txt", summary);
  write_report_page(folder + "/report.html",
                    request.stack.name + ": closed forms against " + material, answer,
                    comparison_details(comparison));
  if (!options.quiet) {
    std::FILE* out = table_stream(options);
    fmt::print(out, "{}", summary);
    if (user_interrupt) fmt::print(out, "interrupted: what was done until then\n");
    fmt::print(out, "\nwrote {}/\n{}", folder, absent_pictures_text());
  }
  write_json(answer, options.json);
  return options.max_error && worst_relative_rmse(comparison) > *options.max_error ? kFailed
                                                                                   : kDone;
}

}  // namespace lamella
