#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/command/command.h"
#include "compare/command/picture_options.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/judgement.h"
#include "compare/judge/side_by_side.h"
#include "compare/judge/verdict_text.h"
#include "compare/options/progress.h"
#include "compare/preview/preview_views.h"
#include "compare/report/compare_page.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/report/report_page.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/percent.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

struct JudgedModel {
  const BoundModel* bound = nullptr;
  std::string name;  // of its files
  double nanoseconds = 0;
  std::vector<LobeComparison> lobes{};
};

Json channel_list(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double v : values) list.push_back(v);
  return list;
}

Json to_json(const LobeComparison& l) {
  return {{"mu_i", l.wi.z == kGrazingLimit ? 0.0 : l.wi.z},
          {"phi_i", phi_degrees(l.wi)},
          {"side", l.reflected ? "reflect" : "transmit"},
          {"order", to_text(l.order)},
          {"energy_truth", channel_list(l.energy_truth)},
          {"energy_standard_error", channel_list(l.energy_error)},
          {"energy_missing", channel_list(l.energy_missing)},
          {"energy_model", channel_list(l.energy_model)},
          {"rmse", l.rmse},
          {"relative_rmse", json_number(l.relative_rmse)},
          {"rmse_without_noise", l.rmse_without_noise},
          {"relative_rmse_without_noise", json_number(l.relative_rmse_without_noise)},
          {"relative_rmse_range",
           {json_number(l.relative_rmse_least), json_number(l.relative_rmse_most)}},
          {"max_error", l.max_error},
          {"p_value", l.p_value},
          {"empty_cells", l.empty_cells},
          {"verdict", to_text(l.verdict)}};
}

std::string missing_text(const LobeComparison& l) {
  return l.is_cut() ? fmt::format("<={:.1e}", luminance(l.energy_missing)) : "none";
}

// `max_order`: of the walks, if any.
std::string table(const std::vector<JudgedModel>& models, std::uint64_t max_order) {
  std::vector<const LobeComparison*> all;
  for (const JudgedModel& m : models)
    for (const LobeComparison& l : m.lobes) all.push_back(&l);
  const bool cut = std::any_of(all.begin(), all.end(), [](const auto* l) { return l->is_cut(); });
  std::string text;
  for (const JudgedModel& m : models) {
    text += fmt::format("\n{} ({:.0f} ns per evaluation)\n{}", m.bound->info->name, m.nanoseconds,
                        told_parameters(*m.bound, 4));
    text += fmt::format("  {:>7} {:>9} {:>5} {:>12} {:>8}{} {:>12} {:>10} {:>10} {:>9}  {}\n",
                        "theta_i", "side", "order", "energy truth", "+-",
                        cut ? fmt::format(" {:>9}", "missing") : "", "energy model", "rel. RMSE",
                        "no noise", "p", "verdict");
    for (const LobeComparison& l : m.lobes)
      text += fmt::format(
          "  {:>7g} {:>9} {:>5} {:>12.5f} {:>8.1e}{} {:>12.5f} {:>10} {:>10} {:>9.2g}  {}\n",
          theta_degrees(l.wi), l.reflected ? "reflect" : "transmit", to_text(l.order),
          luminance(l.energy_truth), luminance(l.energy_error),
          cut ? fmt::format(" {:>9}", missing_text(l)) : "", luminance(l.energy_model),
          percent_cell(l.relative_rmse), percent_cell(l.relative_rmse_without_noise), l.p_value,
          verdict_text(l));
  }
  return text + verdict_legend(all, max_order);
}

Json to_json(const std::vector<SideBySide>& rows) {
  Json list = Json::array();
  for (const SideBySide& r : rows) {
    Json entry{{"mu_i", r.wi.z},
               {"phi_i", phi_degrees(r.wi)},
               {"order", to_text(r.order)},
               {"medium", r.medium},
               {"energy_geometry", r.energy_geometry},
               {"energy_medium", r.energy_medium},
               {"relative_rmse_of_medium", json_number(r.medium_error.rmse)},
               {"noise", json_number(r.medium_error.noise)}};
    if (!r.model.empty()) {
      entry["model"] = r.model;
      entry["energy_model"] = r.energy_model;
      entry["relative_rmse_of_model"] = json_number(r.model_error.rmse);
      entry["relative_rmse_of_both"] = json_number(r.total_error.rmse);
    }
    list.push_back(std::move(entry));
  }
  return list;
}

Json models_json(const std::vector<JudgedModel>& models) {
  Json list = Json::array();
  for (const JudgedModel& m : models) {
    Json lobes = Json::array(), parameters = Json::object();
    for (const LobeComparison& l : m.lobes) lobes.push_back(to_json(l));
    for (const auto& [key, value] : m.bound->parameters.all()) parameters[key] = to_json(value);
    list.push_back({{"name", m.bound->info->name},
                    {"parameters", std::move(parameters)},
                    {"parameter_sources", m.bound->sources},
                    {"ns_per_eval", m.nanoseconds},
                    {"lobes", std::move(lobes)}});
  }
  return list;
}

// Whether a model's noise-free relative RMSE over all orders is beyond --max-error.
bool is_too_far(const std::vector<JudgedModel>& models, const Options& options) {
  double worst = 0;
  for (const JudgedModel& m : models)
    for (const LobeComparison& l : m.lobes)
      // Where nothing arrives any model is infinitely far off: that counts once it is no accident.
      // Where walks were cut, what is certain counts.
      if (l.order == Order::all &&
          (std::isfinite(l.relative_rmse_least) || l.verdict == Verdict::differs))
        worst = std::max(worst, l.relative_rmse_least);
  return options.max_error && worst > *options.max_error;
}

// What a preview costs is not what the comparison may cost: the solver where it applies, whatever
// counted the lobes, else walks enough for a picture.
TruthRequest preview_request(const TruthRequest& request) {
  constexpr std::uint64_t kPreviewWalks = 10000;
  TruthRequest preview = request;
  preview.estimator.reset();
  preview.given.clear();
  preview.effort.walks = std::min(request.effort.walks, kPreviewWalks);
  return preview;
}

Json page_details(const std::vector<RunResult>& runs, std::vector<JudgedModel>& models) {
  std::vector<std::vector<LobeComparison>> lobes;
  Json told = Json::array();
  for (JudgedModel& m : models) {
    lobes.push_back(std::move(m.lobes));
    told.push_back(told_parameters(*m.bound));
  }
  Json details = compare_page_details(runs, lobes);
  details["parameters"] = std::move(told);
  return details;
}

}  // namespace

int compare_command(const Options& options, const std::vector<std::string>& pictures) {
  const TruthRequest request = truth_request(options, stack_of(options));
  const Stack& stack = request.stack;
  const std::vector<PictureFormat> formats = picture_formats_of(pictures);
  const bool previewed = options.preview && !options.answer_only;
  if (previewed) check_preview("compare --preview", stack);
  GroundTruth truth(request, Estimator::analog, terminal_monitor(options));
  const std::vector<BoundModel> models = fitted_models_for(model_requests(options), stack);
  const std::vector<std::string> names = distinct_names(models);
  std::vector<JudgedModel> judged;
  for (std::size_t m = 0; m < models.size(); ++m)
    judged.push_back({&models[m], names[m], nanoseconds_per_eval(*models[m].model)});
  const std::string folder = options.output.empty() ? stack.name + "-compare" : options.output;
  if (!options.answer_only) make_output_folder(folder);

  std::vector<RunResult> runs;
  for (std::size_t k = 0; truth.goes_on(k); ++k) {
    const Truth found = truth.find(k);
    runs.push_back(found.run);
    for (JudgedModel& m : judged)
      for (LobeComparison& l : judge(found, truth.plan(), *m.bound))
        m.lobes.push_back(std::move(l));
  }
  std::vector<LobeComparison*> all;
  for (JudgedModel& m : judged)
    for (LobeComparison& l : m.lobes) all.push_back(&l);
  decide(all);

  std::vector<SideBySide> beside;
  if (stack.grains() && !user_interrupt) beside = side_by_side(request, runs, &user_interrupt);
  Json answer = json_header("compare", request);
  add_choice(answer, truth.choice(), request);
  answer["walks"] = runs.front().walks;
  answer["interrupted"] = user_interrupt.load();
  answer["agrees_within"] = kAgreesWithin;
  answer["models"] = models_json(judged);
  if (!beside.empty()) answer["side_by_side"] = to_json(beside);
  const int status = is_too_far(judged, options) ? kFailed : kDone;
  if (options.answer_only) {
    write_json(answer, options.json);
    return status;
  }

  std::string summary =
      fmt::format("{}: {}{}{}\n", stack.name,
                  runs.front().is_bounded()
                      ? ""
                      : fmt::format("{} walks per direction, ", runs.front().walks),
                  estimator_text(truth.choice(), request),
                  truth.plan().channels == 3 ? fmt::format("; energies: {}", kLuminanceName) : "") +
      table(judged, runs.front().max_order) + (beside.empty() ? "" : side_by_side_table(beside));
  int drawn = 0;
  for (const JudgedModel& m : judged) {
    write_exr(folder + "/" + m.name + ".exr",
              comparison_image(request, runs, m.lobes, to_request(*m.bound)));
    drawn += write_comparison_pictures(folder, m.name, stack.name, runs, m.lobes, formats);
  }
  write_exr(folder + "/truth.exr", simulation_image(request, runs));
  Json details = page_details(runs, judged);
  if (previewed && !user_interrupt) {
    const RunMonitor monitor = terminal_monitor(options);
    const LobeTable lobes = LobeTable::make(preview_request(request), monitor.stop, monitor.solver);
    if (monitor.finished) monitor.finished();
    const PreviewLighting lighting;
    const std::vector<PreviewResult> views =
        preview_views(lobes, models, names, lighting, options.size, &user_interrupt);
    write_preview_files(folder + "/preview_", views, lobes, stack, lighting, formats);
    answer["previews"] = to_json(views);
    if (!formats.empty()) details["previews"] = preview_page_details(views, lobes, lighting);
    summary += fmt::format("\npreview: truth by {}\n{}", lobes.source(), preview_table(views));
  }
  write_file(folder + "/report.json", answer.dump(2) + "\n");
  write_file(folder + "/summary.txt", summary);
  write_report_page(folder + "/report.html", stack.name + ": closed forms against ground truth",
                    answer, details);
  if (!options.quiet) {
    std::FILE* out = table_stream(options);
    fmt::print(out, "{}", summary);
    if (judged.empty()) fmt::print(out, "no closed form applies to this stack (see --model)\n");
    if (user_interrupt) fmt::print(out, "interrupted: what was done until then\n");
    fmt::print(
        out,
        "\nwrote {}/: report.html to look at, truth.exr, an EXR per model, report.json, "
        "summary.txt{}{}\n{}",
        folder, previewed ? ", previews (preview_*)" : "",
        formats.empty() ? "" : fmt::format(" and {} error maps ({})", drawn, endings_text(formats)),
        absent_pictures_text());
  }
  write_json(answer, options.json);
  return status;
}

}  // namespace lamella
