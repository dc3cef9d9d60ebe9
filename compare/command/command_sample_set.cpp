#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <utility>

#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/command/sample_command.h"
#include "compare/distribute/sweep_points.h"
#include "compare/exchange/lobe_archive.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/options/run_settings.h"
#include "compare/ranks/rank_tasks.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/report/lobe_set.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/substrate_model.h"
#include "compare/samples/sample_file.h"
#include "compare/samples/sample_set.h"
#include "compare/samples/stack_design.h"
#include "compare/shards/job_array.h"
#include "compare/truth/ground_truth.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// Stacks that were named, each under its own name.
std::vector<DesignedStack> listed_stacks(const std::vector<std::string>& names) {
  std::vector<DesignedStack> stacks;
  std::set<std::string> taken;
  for (const std::string& name : names) {
    const Stack stack = with_surface_model(load_stack(name));
    if (!taken.insert(stack.name).second)
      throw UsageError(fmt::format(
          "--per-bsdf: found two stacks of the name {}; allowed: files of different names",
          stack.name));
    stacks.push_back({stack.name, to_toml(stack), {}});
  }
  return stacks;
}

// Every combination of the values of --set.
std::vector<DesignedStack> grid_of_stacks(const Stack& stack,
                                          const std::vector<std::string>& sets) {
  std::vector<SweepAxis> axes;
  for (const std::string& text : sets) axes.push_back(parse_sweep_axis(text));
  const SweepPoints points(stack, axes);
  points.check();
  std::vector<DesignedStack> stacks;
  for (std::size_t k = 0; k < points.count(); ++k) {
    DesignedStack one{SweepPoints::name(k), points.toml(k), {}};
    const std::vector<std::size_t> at = points.at(k);
    for (std::size_t a = 0; a < axes.size(); ++a)
      one.values.emplace_back(axes[a].path, axes[a].values[at[a]]);
    stacks.push_back(std::move(one));
  }
  return stacks;
}

std::vector<DesignedStack> stacks_of_set(const Options& options,
                                         const std::vector<std::string>& names) {
  if (options.sets.empty() && options.design.empty()) {
    if (names.empty())
      throw UsageError(
          "--per-bsdf: found one stack alone; allowed: several stacks, or one with --set, or with "
          "--design and --set");
    return listed_stacks(names);
  }
  if (names.size() > 1)
    throw UsageError(
        fmt::format("--set: found {} stacks; allowed: one, whose values are set", names.size()));
  const Stack stack =
      with_surface_model(load_stack(names.empty() ? std::string(kDefaultStack) : names[0]));
  return options.design.empty() ? grid_of_stacks(stack, options.sets)
                                : latin_design(stack, options.design, options.sets, options.seed);
}

Stack parsed(const DesignedStack& one) {
  Stack stack = with_surface_model(
      parse_stack(one.toml, fmt::format("--per-bsdf, stack {}", one.name), one.name));
  for (const Layer& layer : stack.layers)
    if (layer.grid && is_file(*layer.grid))
      throw UsageError(
          fmt::format("--per-bsdf: found the grid {} in stack {}; allowed: stacks without density "
                      "grids",
                      layer.grid->file, one.name));
  return stack;
}

MadeFile walks_file(const Options& options, const Stack& stack, const fs::path& file,
                    const RunMonitor& monitor) {
  const SampleRequest request = sample_request(options, stack);
  SampleFile out(file, request.plan.channels);
  const std::vector<SampleTotals> totals =
      stream_samples(request, monitor, [&](const SampleChunk& chunk) { out.add(chunk); });
  if (monitor.is_stopped()) return {{}, false};
  (void)out.finish(request, totals, {});
  std::uint64_t walks = 0, rows = 0;
  for (const SampleTotals& one : totals) {
    walks += one.walks;
    rows += one.rows;
  }
  return {{{"walks", walks}, {"rows", rows}}};
}

MadeFile lobes_file(const Options& options, const Stack& stack, const fs::path& file,
                    const RunMonitor& monitor) {
  const TruthRequest request = truth_request(options, stack);
  GroundTruth truth(request, Estimator::analog, monitor);
  std::vector<RunResult> runs;
  for (std::size_t k = 0; truth.goes_on(k) && !monitor.is_stopped(); ++k)
    runs.push_back(truth.find(k).run);
  if (monitor.is_stopped()) return {{}, false};
  MadeFile made{{{"estimator", to_text(runs.front().estimator)}, {"walks", Json()}}};
  std::uint64_t walks = 0;
  for (const RunResult& run : runs) walks += run.walks;
  made.about["walks"] = walks;
  LobeSet set = take_lobes(runs);
  set.attributes = file_attributes(request, runs);
  write_file(file, lobe_npz(set, {}, NpzLobes::compact));
  return made;
}

// A line per stack is told instead of its progress.
RunMonitor monitor_of_stacks(RunMonitor monitor) {
  monitor.progress = {};
  monitor.solver = {};
  monitor.finished = {};
  return monitor;
}

std::string values_text(const DesignedStack& stack) {
  std::string text;
  for (const auto& [path, value] : stack.values)
    text += fmt::format("{}{} = {:g}", text.empty() ? "" : " ", path, value);
  return text.empty() ? stack.name : text;
}

}  // namespace

int sample_set_command(const Options& options, const std::vector<std::string>& names) {
  Ranks* const ranks = started_ranks();
  if (ranks) refuse_shard_of_ranks(options);
  const RunMonitor monitor =
      monitor_of_stacks(ranks ? monitor_of_rank(options, *ranks) : terminal_monitor(options));
  if (options.output.empty() || options.output.ends_with(".npz") ||
      options.output.ends_with(".part"))
    throw UsageError(
        fmt::format("-o: found \"{}\" with --per-bsdf; allowed: a folder", options.output));
  if (options.lobes && !options.incident_law.empty())
    throw UsageError(
        "--lobes: found --wi-distribution beside it; allowed: --wi, as lobes have directions");
  std::vector<DesignedStack> stacks = stacks_of_set(options, names);
  for (const DesignedStack& one : stacks) (void)parsed(one);
  const Shard part =
      options.shard.empty() ? Shard{} : shard_from(options.shard, process_environment());
  Json settings = settings_json(options);
  settings["version"] = LAMELLA_VERSION;
  settings["stacks"] = Json::array();
  if (options.design.empty() && options.sets.empty())
    for (const DesignedStack& one : stacks) settings["stacks"].push_back(one.toml);
  else
    settings["stacks"].push_back(
        to_toml(load_stack(names.empty() ? std::string(kDefaultStack) : names[0])));
  const auto make = [&](std::size_t k, const fs::path& file) {
    // Noise of one stack tells nothing of another's.
    Options of_stack = options;
    of_stack.seed = options.seed + k;
    const Stack stack = parsed(stacks[k]);
    MadeFile made = options.lobes ? lobes_file(of_stack, stack, file, monitor)
                                  : walks_file(of_stack, stack, file, monitor);
    made.about["seed"] = of_stack.seed;
    return made;
  };
  const RankTask find = [&](std::uint64_t k) {
    const fs::path folder = options.output;
    const MadeFile made = make(k, folder / set_file_name(stacks[k]));
    return made.whole ? set_entry(folder, k, stacks[k], made).dump() : std::string();
  };
  if (ranks) {
    Json request = settings;
    request["folder"] = options.output;
    agree_by_ranks(request, *ranks);
  }
  if (ranks && ranks->rank() != 0) {
    work_on_tasks(*ranks, find, monitor.stop);
    return kDone;
  }
  SampleSet set(options.output, settings, stacks, part);
  std::FILE* out = table_stream(options);
  const auto tell = [&](std::size_t k, const Json&, bool was_there) {
    if (!options.quiet)
      fmt::print(out, "{} of {}: {}{}\n", k + 1, stacks.size(), values_text(stacks[k]),
                 was_there ? " (was there)" : "");
  };
  if (ranks) {
    const auto keep = [&](std::uint64_t k, const std::string& found) {
      if (found.empty()) return;  // it was interrupted
      set.keep(k, Json::parse(found));
      tell(k, {}, false);
    };
    (void)serve_tasks(*ranks, set.missing(), find, keep, monitor.stop);
  } else {
    set.make(make, tell, [&] { return monitor.is_stopped(); });
  }
  Json header = json_header("samples", options.seed, isa_of(options));
  header["content"] = options.lobes ? "lobes" : "walks";
  header["folder"] = options.output;
  header["interrupted"] = monitor.is_stopped();
  const Json answer = set.write_index(std::move(header));
  if (!options.quiet) {
    if (monitor.is_stopped()) fmt::print(out, "interrupted: the same command goes on\n");
    fmt::print(out, "{}/: {} of {} files, index.json tells of them\n", options.output, set.done(),
               set.count());
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
