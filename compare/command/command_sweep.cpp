#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "compare/command/command.h"
#include "compare/distribute/sweep_points.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/substrate_model.h"
#include "compare/request/sweep_axis.h"
#include "compare/request/truth_request.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

std::optional<Json> read_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) return std::nullopt;
  Json value = Json::parse(in, nullptr, false);
  if (value.is_discarded())
    throw UsageError(fmt::format("{}: found a damaged file; allowed: one that lamella sweep wrote",
                                 path.string()));
  return value;
}

// What a point's answer depends on: a folder holds one sweep only.
Json settings_of(const Options& options, const Stack& stack, const std::vector<SweepAxis>& axes) {
  Json list = Json::array();
  for (const SweepAxis& axis : axes) {
    Json values = Json::array();
    for (const double v : axis.values) values.push_back(json_number(v));
    list.push_back({{"path", axis.path}, {"values", std::move(values)}});
  }
  Json walk_settings = Json::array();
  for (const WalkSetting setting : options.walk_settings) walk_settings.push_back(to_text(setting));
  Json settings{{"version", LAMELLA_VERSION},
                {"of", options.of},
                {"stack", to_json(stack)},
                {"axes", std::move(list)},
                {"incident", options.incident},
                {"walks", options.walks},
                {"grid", options.grid},
                {"estimator", options.estimator},
                {"isa", options.isa},
                {"tolerance", options.tolerance},
                {"walk_options", std::move(walk_settings)},
                {"seed", options.seed},
                {"models", options.models},
                {"as_is", options.as_is}};
  settings["max_order"] = options.max_order ? Json(*options.max_order) : Json();
  settings["thin_from"] = options.thin_from ? Json(*options.thin_from) : Json();
  settings["target_error"] = options.target_error ? Json(*options.target_error) : Json();
  settings["time"] = options.seconds ? Json(*options.seconds) : Json();
  return settings;
}

// Runs one point of the sweep.
CommandAnswer point_answer(const Options& options, const Stack& stack, const RunMonitor& monitor) {
  return options.of == "furnace" ? furnace_answer(options, stack, monitor)
                                 : compare_answer(options, stack, monitor);
}

}  // namespace

int sweep_command(const Options& options) {
  const TruthRequest request = truth_request(options, stack_of(options));
  const Stack& stack = request.stack;
  std::vector<SweepAxis> axes;
  for (const std::string& text : options.sets) axes.push_back(parse_sweep_axis(text));
  const SweepPoints sweep(stack, axes);
  sweep.check();
  const std::size_t count = sweep.count();
  const fs::path folder = options.output.empty() ? stack.name + "-sweep" : options.output;
  const fs::path points = folder / "points";
  make_output_folder(points);
  const Json settings = settings_of(options, stack, axes);
  if (const auto found = read_json(folder / "settings.json"); found && *found != settings)
    throw UsageError(fmt::format(
        "{}: found another sweep (see settings.json there); allowed: -o with a folder of its own",
        folder.string()));
  write_file(folder / "settings.json", settings.dump(2) + "\n");

  std::FILE* out = table_stream(options);
  RunMonitor monitor = terminal_monitor(options);
  monitor.progress = {};  // a line per point is told
  monitor.solver = {};
  monitor.finished = {};
  Json list = Json::array();
  int status = kDone;
  std::size_t done = 0;
  for (std::size_t k = 0; k < count && !user_interrupt; ++k) {
    const fs::path answer_file = points / (SweepPoints::name(k) + ".json");
    std::optional<Json> answer = read_json(answer_file);
    const bool was_there = answer.has_value();
    if (!was_there) {
      const fs::path stack_file = points / (SweepPoints::name(k) + ".toml");
      write_file(stack_file, sweep.toml(k));
      CommandAnswer found =
          point_answer(options, with_surface_model(load_stack(stack_file.string())), monitor);
      status = std::max(status, found.status);
      if (user_interrupt) break;
      write_json(found.json, answer_file.string());
      answer = std::move(found.json);
    }
    ++done;
    if (!options.quiet)
      fmt::print(out, "{} of {}: {}{}\n", k + 1, count, sweep.values(k),
                 was_there ? " (was there)" : "");
    list.push_back({{"at", sweep.at(k)}, {"answer", std::move(*answer)}});
  }
  Json result = json_header("sweep", request);
  result["of"] = options.of;
  result["axes"] = settings["axes"];
  result["interrupted"] = user_interrupt.load();
  result["points"] = std::move(list);
  write_file(folder / "report.json", result.dump(2) + "\n");
  write_report_page(folder / "report.html", stack.name + ": sweep", result, nullptr);
  if (!options.quiet) {
    if (user_interrupt)
      fmt::print(out, "interrupted after {} of {} points: the same command goes on\n", done, count);
    fmt::print(out,
               "wrote {}/: report.html to look at, report.json, a stack and an answer per "
               "point\n",
               folder.string());
  }
  write_json(result, options.json);
  return status;
}

}  // namespace lamella
