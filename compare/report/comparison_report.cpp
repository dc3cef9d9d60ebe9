#include "compare/report/comparison_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compare/files/exr_file.h"
#include "compare/judge/verdict_text.h"
#include "compare/report/compare_page.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/report/map_error.h"
#include "compare/report/texel_record.h"
#include "compare/request/percent.h"
#include "phase/math/degrees.h"
#include "phase/math/luminance.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

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
          {"projection_open", json_number(l.open_share())},
          {"verdict", to_text(l.verdict)}};
}

std::string missing_text(const LobeComparison& l) {
  return l.is_cut() ? fmt::format("<{:.1e}", luminance(l.energy_missing)) : "none";
}

// A line where the quadrature over cells ended before it was exact, by its panels or its time.
std::string open_projection_text(const std::vector<LobeComparison>& lobes) {
  double most = 0;
  for (const LobeComparison& l : lobes) most = std::max(most, l.open_share());
  if (!(most > kProjectionTolerance)) return "";
  return fmt::format(
      "  its projection onto cells was ended at {} panels or {:g} s and leaves open up to {} of a "
      "lobe, which\n  is not held against it\n",
      kProjectionPanels, kProjectionSeconds, percent_text(most));
}

// `max_order`: of the walks, if any.
std::string table(const std::vector<JudgedModel>& models, std::uint64_t max_order) {
  std::vector<const LobeComparison*> all;
  for (const JudgedModel& m : models)
    for (const LobeComparison& l : m.lobes) all.push_back(&l);
  const bool cut = std::any_of(all.begin(), all.end(), [](const auto* l) { return l->is_cut(); });
  std::string text;
  for (const JudgedModel& m : models) {
    text += fmt::format(
        "\n{}{}\n{}", m.bound->info->name,
        m.nanoseconds > 0 ? fmt::format(" ({:.0f} ns per evaluation)", m.nanoseconds) : "",
        told_parameters(*m.bound, 4));
    // Where light is missing the verdict has the range of the rel. RMSE: as it stands it is left
    // out.
    text += fmt::format("  {:>7} {:>8} {:>5} {:>8} {:>7}{} {:>8}{} {:>8} {:>7}  {}\n", "theta_i",
                        "side", "order", "truth", "+-", cut ? fmt::format(" {:>8}", "missing") : "",
                        "model", cut ? "" : fmt::format(" {:>9}", "rel. RMSE"), "no noise", "p",
                        "verdict");
    for (const LobeComparison& l : m.lobes)
      text +=
          fmt::format("  {:>7g} {:>8} {:>5} {:>8.5f} {:>7.1e}{} {:>8.5f}{} {:>8} {:>7.2g}  {}\n",
                      theta_degrees(l.wi), l.reflected ? "reflect" : "transmit", to_text(l.order),
                      luminance(l.energy_truth), luminance(l.energy_error),
                      cut ? fmt::format(" {:>8}", missing_text(l)) : "", luminance(l.energy_model),
                      cut ? "" : fmt::format(" {:>9}", percent_cell(l.relative_rmse)),
                      percent_cell(l.relative_rmse_without_noise), l.p_value, verdict_text(l));
    text += open_projection_text(m.lobes);
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
               {"energy_missing", r.energy_missing},
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
                    {"label", m.label},
                    {"parameters", std::move(parameters)},
                    {"parameter_sources", m.bound->sources},
                    {"ns_per_eval", m.nanoseconds > 0 ? Json(m.nanoseconds) : Json()},
                    {"lobes", std::move(lobes)}});
  }
  return list;
}

}  // namespace

Json comparison_json(const TruthRequest& request, const StackComparison& comparison) {
  Json answer = json_header("compare", request);
  add_choice(answer, comparison.choice, request);
  answer["walks"] = comparison.runs.front().walks;
  answer["interrupted"] = comparison.interrupted;
  answer["agrees_within"] = kAgreesWithin;
  for (const RunResult& error : comparison.map_errors)
    answer["map_error"].push_back(map_error_json(error));
  answer["models"] = models_json(comparison.models);
  if (!comparison.beside.empty()) answer["side_by_side"] = to_json(comparison.beside);
  return answer;
}

Json comparison_details(const StackComparison& comparison) {
  std::vector<std::vector<LobeComparison>> lobes;
  Json told = Json::array();
  for (const JudgedModel& m : comparison.models) {
    lobes.push_back(m.lobes);
    told.push_back(told_parameters(*m.bound));
  }
  Json details = compare_page_details(comparison.runs, lobes);
  details["parameters"] = std::move(told);
  return details;
}

namespace {

// Of a mean over a map that was solved, what its texels leave beside the bounds of the table.
std::string map_error_lines(const StackComparison& comparison) {
  std::string text;
  for (const RunResult& error : comparison.map_errors)
    text +=
        fmt::format("  theta_i {:g}\n{}", theta_degrees(error.incident), map_error_text(error, 4));
  return text.empty()
             ? text
             : "\n  both truth and model are of the same texels, whose choice leaves of the "
               "map's mean\n" +
                   text;
}

}  // namespace

std::string comparison_summary(const TruthRequest& request, const StackComparison& comparison) {
  const RunResult& first = comparison.runs.front();
  return fmt::format(
             "{}: {}{}{}\n", request.stack.name,
             first.is_bounded() ? "" : fmt::format("{} walks per direction, ", first.walks),
             estimator_text(comparison.choice, request),
             comparison.channels == 3 ? fmt::format("; energies: {}", kLuminanceName) : "") +
         table(comparison.models, first.max_order) + map_error_lines(comparison) +
         (comparison.beside.empty() ? "" : side_by_side_table(comparison.beside));
}

int write_comparison_files(const std::string& folder, const TruthRequest& request,
                           const StackComparison& comparison,
                           const std::vector<PictureFormat>& formats, const InputFiles& inputs) {
  const TruthRequest named = named_for_image(request, folder);
  const auto write = [&](const std::string& name, ExrImage image) {
    record_files(image, inputs, folder);
    write_exr(folder + "/" + name + ".exr", image);
  };
  int pictures = 0;
  for (const JudgedModel& m : comparison.models) {
    ExrImage image = comparison_image(named, comparison.runs, m.lobes, to_request(*m.bound));
    if (!m.bound->object.empty())
      image.attributes["lamella.model_file"] = relative_to(m.bound->object, folder).string();
    if (!m.bound->asked.empty()) image.attributes["lamella.model_asked"] = m.bound->asked;
    record_texels(image, request, comparison.texel_ends);
    write(m.name, std::move(image));
    pictures += write_comparison_pictures(folder, m.name, m.label, request.stack.name,
                                          comparison.runs, m.lobes, formats);
  }
  ExrImage truth = simulation_image(named, comparison.runs);
  add_map_errors(truth, comparison.map_errors);
  record_texels(truth, request, comparison.texel_ends);
  write("truth", std::move(truth));
  return pictures;
}

}  // namespace lamella
