#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/substrate_model.h"
#include "compare/request/sweep_axis.h"
#include "compare/request/truth_request.h"
#include "phase/stack/stack_file.h"

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

std::string name_of(std::size_t point) { return fmt::format("{:04}", point); }

// Runs one point of the sweep; its answer is written when it is whole.
int run_point(const Options& options, const fs::path& stack_file, const fs::path& answer) {
  Options one = options;
  one.stack = stack_file.string();
  one.json = answer.string();
  one.html = one.output = "";
  one.quiet = one.answer_only = true;
  return options.of == "furnace" ? furnace_command(one) : compare_command(one);
}

}  // namespace

int sweep_command(const Options& options) {
  const TruthRequest request = truth_request(options, stack_of(options));
  const Stack& stack = request.stack;
  std::vector<SweepAxis> axes;
  std::size_t count = 1;
  for (const std::string& text : options.sets) {
    axes.push_back(parse_sweep_axis(text));
    count *= axes.back().values.size();
  }
  if (count > 10000)
    throw UsageError(fmt::format("--set: found {} points; allowed: at most 10000", count));
  const auto place = [&](std::size_t point) {
    std::vector<std::size_t> at(axes.size());
    for (std::size_t a = axes.size(); a-- > 0; point /= axes[a].values.size())
      at[a] = point % axes[a].values.size();
    return at;
  };
  // Every point's stack is read before the first one runs.
  for (std::size_t k = 0; k < count; ++k) {
    const std::string text = with_values(stack, axes, place(k));
    (void)with_surface_model(parse_stack(text, fmt::format("--set, point {}", k), stack.name));
  }
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
  catch_interrupts();
  Json list = Json::array();
  int status = kDone;
  std::size_t done = 0;
  for (std::size_t k = 0; k < count && !user_interrupt; ++k) {
    const fs::path answer_file = points / (name_of(k) + ".json");
    std::optional<Json> answer = read_json(answer_file);
    const bool was_there = answer.has_value();
    if (!was_there) {
      const fs::path stack_file = points / (name_of(k) + ".toml");
      const fs::path part = points / (name_of(k) + ".part");
      write_file(stack_file, with_values(stack, axes, place(k)));
      status = std::max(status, run_point(options, stack_file, part));
      if (user_interrupt) {
        fs::remove(part);
        break;
      }
      answer = read_json(part);
      fs::rename(part, answer_file);
    }
    ++done;
    if (!options.quiet) {
      fmt::print(out, "{} of {}:", k + 1, count);
      const auto at = place(k);
      for (std::size_t a = 0; a < axes.size(); ++a)
        fmt::print(out, " {} = {:g}", axes[a].path, axes[a].values[at[a]]);
      fmt::print(out, "{}\n", was_there ? " (was there)" : "");
    }
    list.push_back({{"at", place(k)}, {"answer", std::move(*answer)}});
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
