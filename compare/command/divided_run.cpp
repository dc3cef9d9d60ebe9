#include "compare/command/divided_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "compare/command/command.h"
#include "compare/files/content_hash.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/options/run_settings.h"
#include "compare/report/input_files.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/shards/job_array.h"
#include "compare/shards/merged_keeper.h"
#include "compare/shards/part_keeper.h"
#include "compare/truth/ground_truth.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* kPartEnding = ".part";

// Each as its stack file; layers of a map are homogeneous and name no files.
Json texel_texts(const std::vector<Stack>& texels) {
  Json texts = Json::array();
  for (const Stack& texel : texels) texts.push_back(to_toml(texel));
  return texts;
}

Json header_of(const DividedRun& run, const Shard& shard, bool checkpoint, const fs::path& file) {
  const InputFiles inputs(run.stack);
  const fs::path folder = file.parent_path();
  return {{"version", LAMELLA_VERSION},
          {"command", run.command},
          {"part", {shard.index, shard.count}},
          {"checkpoint", checkpoint},
          {"stack", to_toml(with_files_relative_to(run.stack, folder))},
          {"texels", texel_texts(run.texels)},
          {"files", inputs.text(folder)},
          {"settings", identity_of(run, inputs)}};
}

// The pieces of an earlier run that ended at a checkpoint; none where there is no file.
StoredPieces found_in(const fs::path& file, const Json& header, bool quiet) {
  if (!fs::exists(file)) return {};
  const auto held = std::make_shared<const PartFile>(file);
  const PartFile& earlier = *held;
  const auto refuse = [&](const std::string& how) {
    throw UsageError(
        fmt::format("{}: found the checkpoint of another run: {}; allowed: "
                    "--checkpoint with a file of its own, or this one removed",
                    file.string(), how));
  };
  if (earlier.header().value("checkpoint", Json()) != Json(true))
    refuse("it is the part of a run that is done");
  for (const char* key : {"version", "command", "part"})
    if (earlier.header().value(key, Json()) != header[key])
      refuse(fmt::format("its {} is {} instead of {}", key,
                         earlier.header().value(key, Json()).dump(), header[key].dump()));
  const Json settings = earlier.header().value("settings", Json());
  if (settings != header["settings"]) refuse(difference_of_settings(settings, header["settings"]));
  if (!quiet)
    fmt::print(stderr, "lamella: goes on from {}: {} piece{} of the run\n", file.string(),
               earlier.pieces(), earlier.pieces() == 1 ? "" : "s");
  return pieces_of(held);
}

bool is_part_name(const std::string& name) { return name.ends_with(kPartEnding); }

void check_output(const DividedCommand& command, const Options& options, bool divided) {
  if (divided == is_part_name(options.output)) return;
  if (divided)
    throw UsageError(fmt::format("-o: found \"{}\" with --shard; allowed: a name that ends in {}",
                                 options.output, kPartEnding));
  throw UsageError(fmt::format("-o: found \"{}\" without --shard; allowed: {}", options.output,
                               command.output.empty() ? "no -o" : command.output));
}

int do_part(const DividedCommand& command, const DividedRun& run, const Shard& shard) {
  const Options& options = run.options;
  if (!options.json.empty() || !options.html.empty())
    throw UsageError("--shard: found --json or --html beside it; allowed: with lamella merge");
  command.check(run);
  const FileLock lock(options.output);
  std::optional<FileLock> second;
  if (!options.checkpoint.empty()) second.emplace(options.checkpoint);
  const Json header = header_of(run, shard, false, options.output);
  const InputFiles inputs(run.stack);
  PartWork work =
      find_part(command, run, shard, options.checkpoint, terminal_monitor(options), options.quiet);
  inputs.check();
  if (!run.input.empty()) work.pieces.insert_or_assign(kInputPiece, StoredPiece(run.input));
  write_part(options.output, header, work.pieces);
  if (!options.checkpoint.empty()) fs::remove(options.checkpoint);
  if (!options.quiet)
    fmt::print("wrote {}: part {} of {}{}\n", options.output, shard.index, shard.count,
               work.idle ? ", without content: part 1 has the solver's answer" : "");
  return kDone;
}

int do_with_checkpoint(const DividedCommand& command, const DividedRun& run) {
  const Options& options = run.options;
  RunMonitor monitor = terminal_monitor(options);
  const FileLock lock(options.checkpoint);
  const Checkpoint checkpoint{options.checkpoint,
                              options.checkpoint_every.value_or(kCheckpointSeconds),
                              header_of(run, {}, true, options.checkpoint)};
  PartKeeper keeper({}, checkpoint, found_in(options.checkpoint, checkpoint.header, options.quiet),
                    monitor.stop, monitor.warning);
  monitor.keeper = &keeper;
  int status = kDone;
  try {
    status = command.finish(run, monitor);
  } catch (const OutputError&) {
    // What was found is kept where the answer cannot be written, if that can be.
    try {
      keeper.save();
    } catch (const OutputError& error) {
      monitor.warn(fmt::format("no checkpoint: {}", error.what()));
    }
    throw;
  }
  if (user_interrupt) {
    keeper.save();
    if (!options.quiet)
      fmt::print(stderr, "lamella: the same command goes on from {}\n", options.checkpoint);
  } else {
    fs::remove(options.checkpoint);
  }
  return status;
}

}  // namespace

Json identity_of(const DividedRun& run, const InputFiles& inputs) {
  Json settings = settings_json(run.options);
  settings["stack"] = to_toml(with_bare_names(run.stack));
  settings["stack_name"] = run.stack.name;
  settings["texels"] = content_hash(texel_texts(run.texels).dump());
  settings["words"] = run.words;
  settings["input"] = content_hash(run.input);
  settings["files"] = Json::array();
  for (const Json& file : inputs.json("")) settings["files"].push_back(file["sha256"]);
  return settings;
}

PartWork find_part(const DividedCommand& command, const DividedRun& run, const Shard& shard,
                   const std::string& file, RunMonitor monitor, bool quiet) {
  std::optional<Checkpoint> checkpoint;
  StoredPieces found;
  if (!file.empty()) {
    checkpoint = {file, run.options.checkpoint_every.value_or(kCheckpointSeconds),
                  header_of(run, shard, true, file)};
    found = found_in(file, checkpoint->header, quiet);
  }
  PartKeeper keeper(shard, checkpoint, std::move(found), monitor.stop, monitor.warning);
  monitor.keeper = &keeper;
  // The solver's answer is whole: the first part has it.
  const bool idle = run.options.estimator == to_text(Estimator::deterministic) &&
                    run.command != "sweep" && shard.index != 1;
  if (!idle) command.find(run, monitor);
  if (user_interrupt) {
    keeper.save();
    throw UsageError(
        fmt::format("interrupted: no part was written{}",
                    checkpoint ? fmt::format("; the same command goes on from {}", file) : ""));
  }
  return {keeper.pieces(), idle};
}

int do_divided(const DividedCommand& command, const DividedRun& run) {
  const Options& options = run.options;
  Ranks* const ranks = started_ranks();
  check_output(command, options, !options.shard.empty());
  if (options.checkpoint_every && options.checkpoint.empty())
    throw UsageError("--checkpoint-every: found no --checkpoint; allowed: beside it");
  if (!options.shard.empty() && options.checkpoint == options.output)
    throw UsageError("--checkpoint: found the file of -o; allowed: one of its own");
  if (!options.checkpoint.empty()) check_output_file(options.checkpoint);
  if (ranks) return do_by_ranks(command, run, *ranks);
  if (!options.shard.empty())
    return do_part(command, run, shard_from(options.shard, process_environment()));
  if (!options.checkpoint.empty()) return do_with_checkpoint(command, run);
  return command.finish(run, terminal_monitor(options));
}

void check_walks_are_given(const TruthRequest& request) {
  if (request.estimator == Estimator::deterministic) return;
  const auto is_given = [&](WalkSetting setting) {
    return std::find(request.given.begin(), request.given.end(), setting) != request.given.end();
  };
  for (const WalkSetting setting : {WalkSetting::target_error, WalkSetting::seconds})
    if (is_given(setting))
      throw UsageError(
          fmt::format("--shard: found {}, which a part cannot tell for all of them; allowed: "
                      "--walks N, or --estimator deterministic",
                      to_text(setting)));
  if (!is_given(WalkSetting::walks))
    throw UsageError(
        "--shard: found no number of walks, which a clock ends then; allowed: --walks N, or "
        "--estimator deterministic");
}

Stack with_bare_names(Stack stack) {
  for (Layer& layer : stack.layers)
    if (layer.grid && is_file(*layer.grid)) {
      layer.grid->file = fs::path(layer.grid->file).filename().string();
      layer.grid->folder.clear();
    }
  return stack;
}

TruthRequest request_of(const DividedRun& run) {
  TruthRequest request = truth_request(run.options, run.stack);
  request.texels = run.texels;
  return request;
}

void find_truths(const DividedRun& run, const RunMonitor& monitor) {
  GroundTruth truth(request_of(run), Estimator::analog, monitor);
  for (std::size_t k = 0; truth.goes_on(k); ++k) (void)truth.find(k);
}

}  // namespace lamella
