#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "compare/command/accuracy_commands.h"
#include "compare/command/command.h"
#include "compare/judge/accuracy_table.h"
#include "compare/judge/coat_accuracy.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
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

// Off by 10 % and by 30 %.
std::string marked(double share) {
  const char* mark = share >= 0.3 ? "**" : share >= 0.1 ? "*" : "";
  return fmt::format("{}{}{}", mark, three_digits(share), mark);
}

// One table per layering: indices and albedos down, roughnesses across.
void print_coats(std::FILE* out, const std::vector<CoatAccuracy>& coats, const CoatRanges& ranges) {
  std::vector<std::string> layerings;
  for (const CoatAccuracy& row : coats)
    if (std::find(layerings.begin(), layerings.end(), row.layering) == layerings.end())
      layerings.push_back(row.layering);
  for (const std::string& layering : layerings) {
    fmt::print(out, "\n`{}`\n\n| ior | albedo |", layering);
    for (const double roughness : ranges.roughness)
      fmt::print(out, " {} |", roughness == 0 ? "smooth" : fmt::format("alpha {}", roughness));
    fmt::print(out, "\n| --- | --- |");
    for (std::size_t k = 0; k < ranges.roughness.size(); ++k) fmt::print(out, " --- |");
    fmt::print(out, "\n");
    for (const double ior : ranges.ior)
      for (const double albedo : ranges.albedo) {
        fmt::print(out, "| {} | {} |", ior, albedo);
        for (const double roughness : ranges.roughness) {
          const auto row = std::find_if(coats.begin(), coats.end(), [&](const CoatAccuracy& c) {
            return c.layering == layering && c.ior == ior && c.roughness == roughness &&
                   c.albedo == albedo;
          });
          if (row == coats.end())
            fmt::print(out, " – |");
          else
            fmt::print(out, " {} / {} |", marked(row->at_30), marked(row->at_80));
        }
        fmt::print(out, "\n");
      }
  }
}

Json measured_coats(const Options& options, const RunMonitor& monitor, std::FILE* out) {
  std::vector<CoatAccuracy> coats;
  Json rows = Json::array();
  measure_coat_accuracy(options.quick, options.tolerance, monitor, [&](const CoatAccuracy& row) {
    coats.push_back(row);
    rows.push_back({{"layering", row.layering},
                    {"ior", row.ior},
                    {"roughness", row.roughness},
                    {"albedo", row.albedo},
                    {"relative_rmse", numbers({row.at_30, row.at_80})},
                    {"truth_bound", row.bound}});
  });
  if (!options.quiet) print_coats(out, coats, coat_ranges(options.quick));
  return rows;
}

}  // namespace

int accuracy_command(const Options& options) {
  if (!options.output.empty() && !options.spongecake)
    throw UsageError("accuracy: -o: found without --spongecake; allowed: beside --spongecake");
  std::FILE* out = table_stream(options);
  Json answer = json_header("accuracy", options.seed, isa_of(options));
  answer["tolerance"] = options.tolerance;
  answer["quick"] = options.quick;
  const RunMonitor monitor = terminal_monitor(options);
  if (options.spongecake) {
    Json stacks = spongecake_accuracy(options, monitor, out);
    answer["interrupted"] = user_interrupt.load();
    answer["spongecake"] = std::move(stacks);
    answer["rows"] = Json::array();
    write_json(answer, options.json);
    return kDone;
  }
  if (options.coats) {
    Json coats = measured_coats(options, monitor, out);
    answer["interrupted"] = user_interrupt.load();
    answer["coats"] = std::move(coats);
    answer["rows"] = Json::array();
    write_json(answer, options.json);
    return kDone;
  }
  Json rows = Json::array();
  if (!options.quiet)
    fmt::print(out,
               "| stack | model | R 0° | R 30° | R 60° | R 80° | T 0° | T 30° | T 60° | T 80° | "
               "energy off | truth within |\n"
               "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  std::string family;
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
