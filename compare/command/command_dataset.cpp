#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "compare/command/command.h"
#include "compare/ensemble/lobe_dataset.h"
#include "compare/files/content_hash.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/shards/job_array.h"
#include "compare/shards/merged_keeper.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

Json settings_of(const LobeDatasetPlan& plan) {
  return {{"format", 1},
          {"version", LAMELLA_VERSION},
          {"layers", plan.layers},
          {"stacks", plan.stacks},
          {"directions", plan.directions},
          {"walks", plan.walks},
          {"grid", fmt::format("{}x{}", plan.grid.mu_cells, plan.grid.phi_cells)},
          {"seed", plan.seed},
          {"isa", to_text(isa_from_text("auto"))},
          {"stacks_per_file", LobeDatasetPlan::kBlock}};
}

void check_settings(const fs::path& file, const Json& settings) {
  std::ifstream in(file);
  if (!in) return write_file(file, settings.dump(2) + "\n");
  const Json found = Json::parse(in, nullptr, false);
  if (found != settings)
    throw UsageError(fmt::format(
        "{}: found another set: {}; allowed: -o with a folder of its own", file.string(),
        found.is_object() ? difference_of_settings(found, settings) : "a damaged file"));
}

LobeDatasetPlan plan_of(const Options& options, const DatasetOptions& asked) {
  const CellGrid grid = parse_grid(asked.grid);
  return {.layers = asked.layers,
          .stacks = asked.stacks        ? asked.stacks
                    : asked.layers == 1 ? 4000u
                                        : 12000u,
          .walks = options.walks_given ? options.walks : LobeDatasetPlan{}.walks,
          .seed = options.seed,
          .directions = asked.directions,
          .grid = grid};
}

// A block's stacks, or nothing where it was interrupted.
std::vector<LobeDatum> found_block(const LobeDatasetPlan& plan, std::uint64_t first,
                                   const RunMonitor& monitor) {
  std::vector<LobeDatum> data(std::min(LobeDatasetPlan::kBlock, plan.stacks - first));
  tbb::parallel_for(std::size_t{0}, data.size(), [&](std::size_t k) {
    if (!monitor.is_stopped()) data[k] = lobe_datum(plan, first + k);
  });
  if (monitor.is_stopped()) data.clear();
  return data;
}

}  // namespace

int dataset_command(const Options& options, const DatasetOptions& asked) {
  const LobeDatasetPlan plan = plan_of(options, asked);
  if (options.output.empty())
    throw UsageError("dataset: found no -o; allowed: -o FOLDER, where the set is kept");
  const Shard part =
      options.shard.empty() ? Shard{} : shard_from(options.shard, process_environment());
  const RunMonitor monitor = terminal_monitor(options);
  const fs::path folder = options.output;
  make_output_folder(folder);
  check_settings(folder / "settings.json", settings_of(plan));
  const FileLock lock(folder / fmt::format("part-{}-of-{}", part.index, part.count));
  std::FILE* out = table_stream(options);
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  std::uint64_t made = 0;
  for (std::uint64_t block = 0; block < plan.blocks() && !monitor.is_stopped(); ++block) {
    const fs::path file = folder / block_name(block);
    if (!part.has(block) || fs::exists(file)) continue;
    const std::uint64_t first = block * LobeDatasetPlan::kBlock;
    const std::vector<LobeDatum> data = found_block(plan, first, monitor);
    if (data.empty()) break;
    write_file(file, lobe_block(data, first));
    made += data.size();
    double noise = 0;
    for (const LobeDatum& one : data) noise += one.lobes.relative_noise();
    if (!options.quiet)
      fmt::print(out,
                 "{} of {}: noise per cell {:.3f} of the root mean square, {:.0f} stacks per "
                 "minute\n",
                 block_name(block), plan.blocks(), noise / static_cast<double>(data.size()),
                 60 * static_cast<double>(made) / seconds());
    std::fflush(out);
  }
  ContentHash hash;
  std::uint64_t there = 0;
  for (std::uint64_t block = 0; block < plan.blocks(); ++block) {
    const fs::path file = folder / block_name(block);
    if (!fs::exists(file)) continue;
    ++there;
    hash.add(content_hash_of_file(file));
  }
  const std::string digits = hash.digits();
  if (!options.quiet)
    fmt::print(out, "{}/: {} of {} files{}; sha256 of their checksums {}\n", options.output, there,
               plan.blocks(),
               monitor.is_stopped() ? " (interrupted: the same command goes on)" : "", digits);
  Json answer = json_header("dataset", plan.seed, isa_from_text("auto"));
  answer["settings"] = settings_of(plan);
  answer["folder"] = options.output;
  answer["files"] = there;
  answer["of_files"] = plan.blocks();
  answer["made"] = made;
  answer["seconds"] = seconds();
  answer["sha256"] = digits;
  answer["interrupted"] = monitor.is_stopped();
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
