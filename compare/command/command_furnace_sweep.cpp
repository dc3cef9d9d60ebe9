#include <fmt/format.h>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/judge/furnace_sweep.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"

namespace lamella {

int furnace_sweep_command(const Options& options) {
  std::vector<const ModelInfo*> list;
  for (const std::string& name : options.models) {
    const ModelInfo* info = find_or_load_model(name);
    if (!info || info->needs_stack)
      throw UsageError(fmt::format(
          "--sweep: --model: found \"{}\"; allowed: the name of a model that needs no stack",
          name));
    list.push_back(info);
  }
  if (list.empty())
    for (const ModelInfo& info : models())
      if (!info.needs_stack) list.push_back(&info);
  if (!options.html.empty()) check_output_file(options.html);
  std::FILE* out = table_stream(options);
  if (!options.quiet)
    fmt::print(out,
               "| model | configurations | least energy | at | most energy | at | error |\n"
               "| --- | --- | --- | --- | --- | --- | --- |\n");
  nlohmann::ordered_json answer = json_header("furnace", options.seed, isa_of(options));
  answer["theta_i"] = furnace_sweep_angles();
  answer["sweep"] = nlohmann::ordered_json::array();
  for (const ModelInfo* info : list) {
    const FurnaceSweep sweep = sweep_furnace(*info);
    const auto where = [](const SweepExtreme& e) {
      return fmt::format("{:.0f} degrees{}{}", e.theta, e.parameters.empty() ? "" : ", ",
                         e.parameters);
    };
    if (!options.quiet) {
      fmt::print(out, "| `{}` | {} | {:.4f} | {} | {:.4f} | {} | {:.0e} |\n", info->name,
                 sweep.configurations, sweep.least.energy, where(sweep.least), sweep.most.energy,
                 where(sweep.most), sweep.worst_error);
      std::fflush(out);
    }
    const auto extreme = [](const SweepExtreme& e) {
      return nlohmann::ordered_json{
          {"energy", e.energy}, {"theta_i", e.theta}, {"parameters", e.parameters}};
    };
    nlohmann::ordered_json axes = nlohmann::ordered_json::array();
    for (const FurnaceSweepAxis& axis : sweep.axes)
      axes.push_back({{"name", axis.name}, {"values", axis.values}});
    answer["sweep"].push_back({{"name", info->name},
                               {"configurations", sweep.configurations},
                               {"axes", std::move(axes)},
                               {"energies", sweep.energies},
                               {"worst_error", sweep.worst_error},
                               {"least", extreme(sweep.least)},
                               {"most", extreme(sweep.most)}});
  }
  if (!options.html.empty())
    write_report_page(options.html, "White furnaces of closed forms over their parameters", answer,
                      nullptr);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
