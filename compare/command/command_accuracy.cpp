#include <fmt/format.h>

#include "compare/command/command.h"
#include "compare/judge/accuracy_table.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/interrupt.h"
#include "compare/request/percent.h"
#include "compare/request/run_monitor.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

int accuracy_command(const Options& options) {
  std::FILE* out = table_stream(options);
  Json answer = json_header("accuracy", options.seed, isa_of(options));
  answer["tolerance"] = options.tolerance;
  answer["quick"] = options.quick;
  Json rows = Json::array();
  if (!options.quiet)
    fmt::print(out,
               "| stack | model | 0° | 30° | 60° | 80° | energy off | truth within |\n"
               "| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  std::string family;
  const RunMonitor monitor = terminal_monitor(options);
  measure_model_accuracy(options.quick, options.tolerance, monitor, [&](const ModelAccuracy& row) {
    if (!options.quiet) {
      if (row.family != family) fmt::print(out, "| **{}** | | | | | | | |\n", row.family);
      fmt::print(out, "| {} | `{}` |", row.stack, row.model);
      for (const double rmse : row.relative_rmse) fmt::print(out, " {} |", percent_cell(rmse));
      fmt::print(out, " {:.2g} | {:.0e} |\n", row.energy_off, row.bound);
      std::fflush(out);
    }
    family = row.family;
    rows.push_back({{"family", row.family},
                    {"stack", row.stack},
                    {"model", row.model},
                    {"relative_rmse", row.relative_rmse},
                    {"energy_off", row.energy_off},
                    {"truth_bound", row.bound}});
  });
  answer["interrupted"] = user_interrupt.load();
  answer["rows"] = std::move(rows);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
