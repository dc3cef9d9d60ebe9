#include <fmt/format.h>

#include "analytic/model_plugin.h"
#include "compare/closed_form_command.h"
#include "compare/furnace_sweep.h"
#include "compare/json_report.h"

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
  std::FILE* out = table_stream(options);
  if (!options.quiet)
    fmt::print(out,
               "| model | configurations | least energy | at | most energy | at |\n"
               "| --- | --- | --- | --- | --- | --- |\n");
  nlohmann::ordered_json answer = json_header("furnace", options);
  answer["sweep"] = nlohmann::ordered_json::array();
  for (const ModelInfo* info : list) {
    const FurnaceSweep sweep = sweep_furnace(*info);
    const auto where = [](const SweepExtreme& e) {
      return fmt::format("{:.0f} degrees{}{}", e.theta, e.parameters.empty() ? "" : ", ",
                         e.parameters);
    };
    if (!options.quiet) {
      fmt::print(out, "| `{}` | {} | {:.4f} | {} | {:.4f} | {} |\n", info->name,
                 sweep.configurations, sweep.least.energy, where(sweep.least), sweep.most.energy,
                 where(sweep.most));
      std::fflush(out);
    }
    const auto extreme = [](const SweepExtreme& e) {
      return nlohmann::ordered_json{
          {"energy", e.energy}, {"theta_i", e.theta}, {"parameters", e.parameters}};
    };
    answer["sweep"].push_back({{"name", info->name},
                               {"configurations", sweep.configurations},
                               {"least", extreme(sweep.least)},
                               {"most", extreme(sweep.most)}});
  }
  write_json(answer, options);
  return kDone;
}

}  // namespace lamella
