#include <fmt/format.h>

#include <algorithm>
#include <string>

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

// Errors of a millionth stand beside others of a hundred per cent: three significant digits.
std::string three_digits(double share) {
  const double percent = 100 * share;
  if (!(percent < 99.95)) return percent_text(share);
  // Three significant digits, in plain numbers.
  const std::string rounded = fmt::format("{:.2e}", percent);
  const int exponent = percent > 0 ? std::stoi(rounded.substr(rounded.find('e') + 1)) : 0;
  return fmt::format("{:.{}f} %", percent, std::max(0, 2 - exponent));
}

// One per incident direction; dashes where nothing comes through.
std::string cells_of(const std::vector<double>& shares) {
  if (shares.empty()) return " – | – | – | – |";
  std::string text;
  for (const double share : shares) text += fmt::format(" {} |", three_digits(share));
  return text;
}

Json numbers(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double v : values) list.push_back(json_number(v));
  return list;
}

}  // namespace

int accuracy_command(const Options& options) {
  std::FILE* out = table_stream(options);
  Json answer = json_header("accuracy", options.seed, isa_of(options));
  answer["tolerance"] = options.tolerance;
  answer["quick"] = options.quick;
  Json rows = Json::array();
  if (!options.quiet)
    fmt::print(out,
               "| stack | model | R 0° | R 30° | R 60° | R 80° | T 0° | T 30° | T 60° | T 80° | "
               "energy off | truth within |\n"
               "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  std::string family;
  const RunMonitor monitor = terminal_monitor(options);
  measure_model_accuracy(options.quick, options.tolerance, monitor, [&](const ModelAccuracy& row) {
    if (!options.quiet) {
      if (row.family != family) fmt::print(out, "| **{}** | | | | | | | | | | | |\n", row.family);
      fmt::print(out, "| {} | `{}` |{}{} {:.2g} | {:.0e} |\n", row.stack, row.model,
                 cells_of(row.reflected), cells_of(row.transmitted), row.energy_off, row.bound);
      std::fflush(out);
    }
    family = row.family;
    rows.push_back({{"family", row.family},
                    {"stack", row.stack},
                    {"model", row.model},
                    {"relative_rmse", numbers(row.reflected)},
                    {"relative_rmse_transmitted", numbers(row.transmitted)},
                    {"energy_off", row.energy_off},
                    {"truth_bound", row.bound}});
  });
  answer["interrupted"] = user_interrupt.load();
  answer["rows"] = std::move(rows);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
