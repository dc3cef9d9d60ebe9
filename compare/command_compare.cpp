#include <fmt/format.h>

#include <cmath>

#include "compare/command.h"
#include "compare/compare_page.h"
#include "compare/ground_truth.h"
#include "compare/json_report.h"
#include "compare/lobe_files.h"
#include "compare/model_request.h"
#include "compare/output_folder.h"
#include "compare/report_page.h"
#include "compare/side_by_side.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

struct JudgedModel {
  BoundModel bound;
  double nanoseconds = 0;
  std::vector<LobeComparison> lobes;
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
          {"energy_model", channel_list(l.energy_model)},
          {"rmse", l.rmse},
          {"relative_rmse", json_number(l.relative_rmse)},
          {"rmse_without_noise", l.rmse_without_noise},
          {"relative_rmse_without_noise", json_number(l.relative_rmse_without_noise)},
          {"max_error", l.max_error},
          {"p_value", l.p_value},
          {"empty_cells", l.empty_cells},
          {"verdict", to_text(l.verdict)}};
}

std::string verdict_text(const LobeComparison& l) {
  if (l.verdict != Verdict::differs) return to_text(l.verdict);
  if (l.relative_rmse_without_noise == 0 || std::isinf(l.relative_rmse_without_noise))
    return "differs";
  return fmt::format("differs by {:.2g} %", 100 * l.relative_rmse_without_noise);
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v / static_cast<double>(values.size());
  return sum;
}

std::string table(const std::vector<JudgedModel>& models) {
  std::string text;
  for (const JudgedModel& m : models) {
    text += fmt::format("\n{}", m.bound.info->name);
    // What is at its default says nothing.
    for (const auto& [key, value] : m.bound.parameters.all()) {
      const ParameterInfo* info = find(m.bound.info->parameters, key);
      if (!info || info->default_value.empty() || parse_value(*info, info->default_value) != value)
        text += fmt::format(", {} = {}", key, to_text(value));
    }
    text += fmt::format(" ({:.0f} ns per evaluation)\n", m.nanoseconds);
    text += fmt::format("  {:>7} {:>9} {:>5} {:>12} {:>8} {:>12} {:>9} {:>9} {:>9}  {}\n",
                        "theta_i", "side", "order", "energy truth", "+-", "energy model",
                        "rel. RMSE", "no noise", "p", "verdict");
    for (const LobeComparison& l : m.lobes)
      text += fmt::format(
          "  {:>7g} {:>9} {:>5} {:>12.5f} {:>8.1e} {:>12.5f} {:>8.2f}% {:>8.2f}% {:>9.2g}  {}\n",
          theta_degrees(l.wi), l.reflected ? "reflect" : "transmit", to_text(l.order),
          mean(l.energy_truth), mean(l.energy_error), mean(l.energy_model), 100 * l.relative_rmse,
          100 * l.relative_rmse_without_noise, l.p_value, verdict_text(l));
  }
  return text;
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
               {"relative_rmse_of_medium", r.medium_error.rmse},
               {"noise", r.medium_error.noise}};
    if (!r.model.empty()) {
      entry["model"] = r.model;
      entry["energy_model"] = r.energy_model;
      entry["relative_rmse_of_model"] = r.model_error.rmse;
      entry["relative_rmse_of_both"] = r.total_error.rmse;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

int compare_command(const Options& options) {
  const Stack stack = stack_of(options);
  GroundTruth truth(stack, options, parse_grid(options.grid), Estimator::analog);
  std::vector<JudgedModel> judged;
  for (BoundModel& bound : models_for(options, stack)) {
    const double nanoseconds = nanoseconds_per_eval(*bound.model);
    judged.push_back({std::move(bound), nanoseconds, {}});
  }
  const std::string folder = options.output.empty() ? stack.name + "-compare" : options.output;
  if (!options.answer_only) make_output_folder(folder);

  std::vector<RunResult> runs;
  for (std::size_t k = 0; k < truth.directions().size() && !interrupted; ++k) {
    const Truth found = truth.find(k);
    const RunResult& run = runs.emplace_back(found.run);
    for (JudgedModel& m : judged)
      for (const bool reflected : {true, false}) {
        if (!reflected && !truth.plan().transmits) continue;
        const bool up = (run.incident.z > 0) == reflected;
        const ProjectedLobes projected =
            project(*m.bound.model, *m.bound.info, run.incident, run.grid, up, run.channels);
        for (LobeComparison& l : compare(run, found.batches.get(), projected, reflected))
          m.lobes.push_back(std::move(l));
      }
  }
  std::vector<LobeComparison*> all;
  for (JudgedModel& m : judged)
    for (LobeComparison& l : m.lobes) all.push_back(&l);
  decide(all);

  std::vector<SideBySide> beside;
  if (stack.grains() && !interrupted) beside = side_by_side(stack, runs, options);
  const std::string summary =
      fmt::format("{}: {}{}{}\n", stack.name,
                  runs.front().is_bounded()
                      ? ""
                      : fmt::format("{} walks per direction, ", runs.front().walks),
                  estimator_text(truth.choice(), options),
                  truth.plan().channels == 3 ? "; energies are means over r, g, b" : "") +
      table(judged) + (beside.empty() ? "" : side_by_side_table(beside));
  Json answer = json_header("compare", stack, options);
  add_choice(answer, truth.choice(), options);
  answer["walks"] = runs.front().walks;
  answer["interrupted"] = interrupted.load();
  Json list = Json::array();
  int pictures = 0;
  double worst = 0;
  for (const JudgedModel& m : judged) {
    Json lobes = Json::array();
    for (const LobeComparison& l : m.lobes) {
      lobes.push_back(to_json(l));
      // Where nothing arrives any model is infinitely far off: that counts once it is no accident.
      if (l.order == Order::all &&
          (std::isfinite(l.relative_rmse_without_noise) || l.verdict == Verdict::differs))
        worst = std::max(worst, l.relative_rmse_without_noise);
    }
    Json parameters = Json::object();
    for (const auto& [key, value] : m.bound.parameters.all()) parameters[key] = to_json(value);
    list.push_back({{"name", m.bound.info->name},
                    {"parameters", std::move(parameters)},
                    {"ns_per_eval", m.nanoseconds},
                    {"lobes", std::move(lobes)}});
    // Two requests of one model get a number each.
    std::string name = m.bound.info->name;
    int same = 0, before = 0;
    for (const JudgedModel& other : judged) {
      if (&other == &m) before = same;
      same += other.bound.info == m.bound.info;
    }
    if (same > 1) name += fmt::format("_{}", before);
    if (options.answer_only) continue;
    write_exr(folder + "/" + name + ".exr",
              comparison_image(stack, runs, m.lobes, options, to_request(m.bound)));
    pictures += write_comparison_pictures(folder, name, stack.name, runs, m.lobes);
  }
  answer["models"] = std::move(list);
  if (!beside.empty()) answer["side_by_side"] = to_json(beside);
  if (options.answer_only) {
    write_json(answer, options);
    return options.max_error && worst > *options.max_error ? kFailed : kDone;
  }
  write_exr(folder + "/truth.exr", simulation_image(stack, runs, options));
  write_file(folder + "/report.json", answer.dump(2) + "\n");
  write_file(folder + "/summary.txt", summary);
  std::vector<std::vector<LobeComparison>> lobes;
  for (JudgedModel& m : judged) lobes.push_back(std::move(m.lobes));
  write_report_page(folder + "/report.html", stack.name + ": closed forms against ground truth",
                    answer, compare_page_details(runs, lobes));
  if (!options.quiet) {
    std::FILE* out = table_stream(options);
    fmt::print(out, "{}", summary);
    if (judged.empty()) fmt::print(out, "no closed form applies to this stack (see --model)\n");
    if (interrupted) fmt::print(out, "interrupted: what was done until then\n");
    fmt::print(out,
               "\nwrote {}/: report.html to look at, truth.exr, an EXR per model, report.json, "
               "summary.txt "
               "and {} error maps (*.png)\n",
               folder, pictures);
  }
  write_json(answer, options);
  return options.max_error && worst > *options.max_error ? kFailed : kDone;
}

}  // namespace lamella
