#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/distribute/sweep_points.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/ranks/rank_tasks.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/report/sweep_table.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/run_keeper.h"
#include "compare/request/stack_parameters.h"
#include "compare/request/substrate_model.h"
#include "compare/request/sweep_axis.h"
#include "compare/request/truth_request.h"
#include "compare/shards/merged_keeper.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

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

// A model as --model has it, a shared object named for a text in `folder`.
std::string named_model(const std::string& text, const fs::path& folder) {
  const std::string name = parse_model_request(text).name;
  if (!is_plugin_path(name)) return text;
  return relative_to(name, folder).string() + text.substr(name.size());
}

// What a point's answer depends on: a folder holds one sweep only.
Json settings_of(const Options& options, const Stack& stack, const std::vector<SweepAxis>& axes,
                 const InputFiles& inputs, const fs::path& folder) {
  Json list = Json::array(), models = Json::array();
  for (const SweepAxis& axis : axes) {
    Json values = Json::array();
    for (const double v : axis.values) values.push_back(json_number(v));
    list.push_back({{"path", axis.path}, {"values", std::move(values)}});
  }
  Json walk_settings = Json::array();
  for (const WalkSetting setting : options.walk_settings) walk_settings.push_back(to_text(setting));
  for (const std::string& text : options.models) models.push_back(named_model(text, folder));
  Json settings{{"version", LAMELLA_VERSION},
                {"of", options.of},
                {"stack", to_json(with_files_relative_to(stack, folder))},
                {"files", inputs.json(folder)},
                {"axes", std::move(list)},
                {"incident", options.incident},
                {"walks", options.walks},
                {"grid", options.grid},
                {"estimator", options.estimator},
                {"isa", to_text(isa_of(options))},
                {"tolerance", options.tolerance},
                {"walk_options", std::move(walk_settings)},
                {"seed", options.seed},
                {"models", std::move(models)},
                {"as_is", options.as_is}};
  settings["max_order"] = options.max_order ? Json(*options.max_order) : Json();
  settings["thin_from"] = options.thin_from ? Json(*options.thin_from) : Json();
  settings["sampling"] = options.sampling;
  settings["walk_order_1"] = options.walk_order_1;
  settings["target_error"] = options.target_error ? Json(*options.target_error) : Json();
  settings["time"] = options.seconds ? Json(*options.seconds) : Json();
  settings["max_error"] = options.max_error ? Json(*options.max_error) : Json();
  return settings;
}

// Runs one point of the sweep.
CommandAnswer point_answer(const Options& options, const Stack& stack, const RunMonitor& monitor) {
  return options.of == "furnace" ? furnace_answer(options, stack, monitor)
                                 : compare_answer(options, stack, monitor);
}

// In words, where the sweep of a folder is another than the one that is asked for.
std::string difference_of_sweeps(const Json& there, const Json& asked) {
  if (const Json files = there.value("files", Json::array()); files != asked["files"])
    for (const Json& file : asked["files"])
      for (const Json& other : files)
        if (other.value("name", "") == file["name"] && other != file)
          return fmt::format("{} had another content, of sha256 {}",
                             file["name"].get<std::string>(), other.value("sha256", "unknown"));
  for (const Json& other : there.value("files", Json::array())) {
    const auto is_it = [&](const Json& file) { return file["name"] == other.value("name", ""); };
    if (std::none_of(asked["files"].begin(), asked["files"].end(), is_it))
      return fmt::format("{} was read there and is not now", other.value("name", ""));
  }
  return difference_of_settings(there, asked);
}

// The exit status that an answer stands for, as the command that gave it had it.
int point_status(const Json& answer, const Options& options) {
  if (options.of == "furnace") return answer.value("verdict", "") == "fail" ? kFailed : kDone;
  if (!options.max_error) return kDone;
  for (const Json& model : answer.value("models", Json::array()))
    for (const Json& lobe : model.value("lobes", Json::array())) {
      if (lobe.value("order", "") != "all") continue;
      // What is certain, as `compare` has it (worst_relative_rmse).
      const Json error = lobe.value("relative_rmse_range", Json::array({Json()})).front();
      if (error.is_number() ? error.get<double>() > *options.max_error
                            : lobe.value("verdict", "") == "differs")
        return kFailed;
    }
  return kDone;
}

std::vector<SweepAxis> axes_of(const Options& options) {
  std::vector<SweepAxis> axes;
  for (const std::string& text : options.sets) axes.push_back(parse_sweep_axis(text));
  return axes;
}

// Before any work: every point's stack and every model can be read.
void check_sweep(const DividedRun& run) {
  SweepPoints(run.stack, axes_of(run.options)).check();
  for (const ModelRequest& request : model_requests(run.options))
    check_request(without_stack_key(request, run.stack));
}

// A line per point is told instead of its progress, and a warning once: what is odd about a grid's
// file is the same at every point.
RunMonitor monitor_of_points(RunMonitor monitor) {
  monitor.progress = {};
  monitor.solver = {};
  monitor.finished = {};
  monitor.keeper = nullptr;
  // Shared, since points have copies of the monitor.
  monitor.warning = [told = std::make_shared<std::set<std::string>>(),
                     warn = monitor.warning](const std::string& message) {
    if (told->insert(message).second && warn) warn(message);
  };
  return monitor;
}

// The answer of one point as a part or a rank has it, its files named from `folder`.
std::string found_point(const DividedRun& run, const SweepPoints& sweep, std::size_t k,
                        const InputFiles& inputs, const fs::path& folder,
                        const RunMonitor& monitor) {
  CommandAnswer found =
      point_answer(run.options,
                   with_surface_model(parse_stack(sweep.toml(k), fmt::format("--set, point {}", k),
                                                  SweepPoints::name(k))),
                   monitor);
  add_files(found.json, inputs);
  return named_for(std::move(found.json), folder).dump();
}

// A part of a sweep: the answers of some points, their files named from where the part will lie.
void find_points(const DividedRun& run, const RunMonitor& monitor) {
  const Options& options = run.options;
  const SweepPoints sweep(with_files_relative_to(run.stack, ""), axes_of(options));
  const fs::path folder = fs::path(options.output).parent_path();
  const RunMonitor of_points = monitor_of_points(monitor);
  const InputFiles inputs(run.stack);
  for (std::size_t k = 0; k < sweep.count() && !user_interrupt; ++k)
    (void)monitor.keeper->piece([&] {
      std::string found = found_point(run, sweep, k, inputs, folder, of_points);
      if (!options.quiet) fmt::print("{} of {}: {}\n", k + 1, sweep.count(), sweep.values(k));
      return found;
    });
}

// The answer of a point that is kept, its files named for the folder of points.
Json kept_answer(const std::string& text, const fs::path& from, const fs::path& points) {
  Json answer = Json::parse(text, nullptr, false);
  if (!answer.is_object())
    throw UsageError("found no answer of a point; allowed: parts that lamella sweep wrote");
  return named_for(std::move(answer), points, from);
}

// `ranks`: that find the points that are not in the folder yet; nullptr: this process does.
int sweep_among(const DividedRun& run, const RunMonitor& of_run, Ranks* ranks) {
  const Options& options = run.options;
  const TruthRequest request = truth_request(options, run.stack);
  const Stack& stack = request.stack;
  check_sweep(run);
  const std::vector<SweepAxis> axes = axes_of(options);
  const SweepPoints sweep(stack, axes);
  const std::size_t count = sweep.count();
  const fs::path folder = options.output.empty() ? stack.name + "-sweep" : options.output;
  const fs::path points = folder / "points";
  make_output_folder(points);
  const FolderLock lock(folder);
  const InputFiles inputs(stack, objects_among(model_requests(options)));
  const Json settings = settings_of(options, stack, axes, inputs, folder);
  if (const auto found = read_json(folder / "settings.json"); found && *found != settings)
    throw UsageError(
        fmt::format("{}: found another sweep, {}; allowed: -o with a folder of its own",
                    (folder / "settings.json").string(), difference_of_sweeps(*found, settings)));
  write_file(folder / "settings.json", settings.dump(2) + "\n");

  const SweepPoints written(with_files_relative_to(stack, points), axes);
  std::FILE* out = table_stream(options);
  const RunMonitor monitor = monitor_of_points(of_run);
  const auto file_of = [&](std::size_t k, const char* ending) {
    return points / (SweepPoints::name(k) + ending);
  };
  const auto tell = [&](std::size_t k, const char* more) {
    if (!options.quiet) fmt::print(out, "{} of {}: {}{}\n", k + 1, count, sweep.values(k), more);
  };
  std::set<std::uint64_t> told;
  if (ranks) {
    std::vector<std::uint64_t> missing;
    for (std::size_t k = 0; k < count; ++k)
      if (!fs::exists(file_of(k, ".json"))) missing.push_back(k);
    const SweepPoints here(with_files_relative_to(run.stack, ""), axes);
    const auto keep = [&](std::uint64_t k, const std::string& found) {
      write_file(file_of(k, ".toml"), written.toml(k));
      write_file(file_of(k, ".json"), kept_answer(found, {}, points).dump(2) + "\n");
      tell(k, "");
    };
    told = serve_tasks(
        *ranks, missing,
        [&](std::uint64_t k) { return found_point(run, here, k, inputs, {}, monitor); }, keep,
        of_run.stop);
    inputs.check();
  }
  Json list = Json::array();
  int status = kDone;
  std::size_t done = 0;
  for (std::size_t k = 0; k < count && !user_interrupt; ++k) {
    const fs::path answer_file = file_of(k, ".json");
    std::optional<Json> answer = read_json(answer_file);
    const bool was_there = answer.has_value();
    std::optional<std::string> kept;
    if (of_run.keeper) kept = of_run.keeper->piece({});
    const fs::path stack_file = file_of(k, ".toml");
    if (!was_there) write_file(stack_file, written.toml(k));
    if (!was_there && kept) {
      answer = kept_answer(*kept, run.folder, points);
      write_file(answer_file, answer->dump(2) + "\n");
    } else if (!was_there) {
      inputs.check();
      CommandAnswer found =
          point_answer(options, with_surface_model(load_stack(stack_file.string())), monitor);
      status = std::max(status, found.status);
      if (user_interrupt) break;
      inputs.check();
      add_files(found.json, inputs);
      write_json(found.json, answer_file.string());
      answer = named_for(std::move(found.json), points);
    }
    status = std::max(status, point_status(*answer, options));
    ++done;
    if (!told.contains(k)) tell(k, was_there ? " (was there)" : "");
    list.push_back({{"at", sweep.at(k)}, {"answer", named_for(std::move(*answer), "", points)}});
  }
  Json result = json_header("sweep", request);
  result["of"] = options.of;
  result["axes"] = settings["axes"];
  result["interrupted"] = user_interrupt.load();
  result["points"] = std::move(list);
  add_files(result, inputs);
  write_json(result, (folder / "report.json").string());
  write_report_page(folder / "report.html", stack.name + ": sweep", result, nullptr);
  if (!options.quiet) {
    fmt::print(out, "{}", sweep_table(result));
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

int sweep_run(const DividedRun& run, const RunMonitor& monitor) {
  return sweep_among(run, monitor, nullptr);
}

int sweep_by_ranks(const DividedRun& run, const RunMonitor& monitor, Ranks& ranks) {
  if (ranks.rank() == 0) return sweep_among(run, monitor, &ranks);
  const SweepPoints sweep(with_files_relative_to(run.stack, ""), axes_of(run.options));
  const InputFiles inputs(run.stack, objects_among(model_requests(run.options)));
  const RunMonitor of_points = monitor_of_points(monitor);
  work_on_tasks(
      ranks, [&](std::uint64_t k) { return found_point(run, sweep, k, inputs, {}, of_points); },
      monitor.stop);
  return kDone;
}

}  // namespace

const DividedCommand& sweep_divided() {
  static const DividedCommand command{"sweep",     "FOLDER",  check_sweep,
                                      find_points, sweep_run, sweep_by_ranks};
  return command;
}

int sweep_command(const Options& options) {
  if (!options.checkpoint.empty() && options.shard.empty())
    throw UsageError(
        "--checkpoint: found it without --shard for a sweep, which goes on in its folder; allowed: "
        "with --shard I/N");
  return do_divided(sweep_divided(), {"sweep", options, stack_of(options)});
}

}  // namespace lamella
