#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/options/progress.h"
#include "compare/ranks/sent_pieces.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/shards/merged_keeper.h"
#include "compare/shards/part_keeper.h"
#include "compare/truth/ground_truth.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostCounted = 64, kMostModelled = 1024;
// Of the model: a network as clusters have it.
constexpr double kLatency = 20e-6, kBytesPerSecond = 1e9;
// Walks per direction that are timed; bytes do not depend on walks.
constexpr std::uint64_t kTimedWalks = 1 << 17;

DividedRun with_walks(DividedRun run, std::uint64_t walks) {
  run.options.walks = walks;
  return run;
}

std::map<std::uint64_t, std::string> found_by(const DividedRun& run, Shard shard,
                                              const RunMonitor& monitor) {
  PartKeeper keeper(shard, {}, {}, monitor.stop, {});
  RunMonitor own{.stop = monitor.stop, .keeper = &keeper};
  find_truths(run, own);
  return loaded(keeper.pieces());
}

// What all ranks but the first send to it; `parts`: what they hold.
std::uint64_t sent_bytes(const DividedRun& run, int ranks, const RunMonitor& monitor,
                         std::vector<std::unique_ptr<Pieces>>& parts) {
  std::uint64_t bytes = 0;
  for (int k = 0; k < ranks && !monitor.is_stopped(); ++k) {
    auto pieces = found_by(
        run, {static_cast<std::uint64_t>(k) + 1, static_cast<std::uint64_t>(ranks)}, monitor);
    if (k > 0) bytes += sent_pieces(pieces).size();
    parts.push_back(std::make_unique<SentPieces>(fmt::format("rank {}", k), std::move(pieces)));
  }
  return bytes;
}

// The largest share of the walks that a rank has. The first piece is the estimator's choice.
double largest_share(int ranks, std::size_t directions) {
  int most = 0;
  for (int k = 0; k < ranks; ++k) {
    const Shard shard{static_cast<std::uint64_t>(k) + 1, static_cast<std::uint64_t>(ranks)};
    int own = 0;
    for (std::size_t d = 0; d < directions; ++d) {
      const BatchRange range = shard.batches(d + 1);
      own += range.end - range.first;
    }
    most = std::max(most, own);
  }
  return static_cast<double>(most) / static_cast<double>(kBatches * directions);
}

struct Measured {
  double seconds_per_walk = 0;  // of the processor, all directions
  double setup = 0, reduction = 0;
  std::vector<std::pair<int, std::uint64_t>> bytes{};  // by ranks
};

Measured measure(const DividedRun& run, const RunMonitor& monitor) {
  Measured found;
  const std::uint64_t walks = std::min(run.options.walks, kTimedWalks);
  double before = cpu_seconds();
  (void)found_by(with_walks(run, kBatches), {}, monitor);
  found.setup = cpu_seconds() - before;
  before = cpu_seconds();
  (void)found_by(with_walks(run, walks), {}, monitor);
  found.seconds_per_walk =
      std::max(cpu_seconds() - before - found.setup, 1e-9) / static_cast<double>(walks);
  const DividedRun quick = with_walks(run, kBatches);
  for (int ranks = 1; ranks <= kMostCounted; ranks *= 2) {
    std::vector<std::unique_ptr<Pieces>> parts;
    found.bytes.emplace_back(ranks, sent_bytes(quick, ranks, monitor, parts));
    if (ranks < kMostCounted || monitor.is_stopped()) continue;
    std::vector<const Pieces*> all;
    for (const auto& part : parts) all.push_back(part.get());
    MergedKeeper keeper(std::move(all));
    RunMonitor merging{.keeper = &keeper};
    const double start = cpu_seconds();
    find_truths(quick, merging);
    found.reduction = std::max(cpu_seconds() - start - found.setup, 0.0);
  }
  return found;
}

}  // namespace

int scaling_command(const Options& given) {
  Options options = given;
  if (options.walk_settings.empty()) options.walk_settings = {WalkSetting::walks};
  if (options.estimator == "auto") options.estimator = to_text(Estimator::analog);
  const DividedRun run{"simulate", options, stack_of(options)};
  const TruthRequest request = truth_request(options, run.stack);
  if (request.estimator == Estimator::deterministic)
    throw UsageError(
        "--estimator: found \"deterministic\", whose answer is one piece of work; allowed: analog, "
        "next-event");
  const RunMonitor monitor = terminal_monitor(options);
  const std::size_t directions = request.directions.size();
  const Measured found = measure(run, monitor);
  if (user_interrupt) throw UsageError("interrupted: nothing was measured");
  const auto walks = static_cast<double>(options.walks * directions);
  const double work = found.seconds_per_walk * static_cast<double>(options.walks);
  const auto seconds = [&](int ranks) {
    // Every rank's bytes but the first's: all of them, nearly, however many ranks there are.
    const double all =
        static_cast<double>(found.bytes.back().second) * kMostCounted / (kMostCounted - 1);
    return found.setup + work * largest_share(ranks, directions) +
           (ranks > 1 ? found.reduction + all * (ranks - 1) / ranks / kBytesPerSecond +
                            kLatency * static_cast<double>(messages_of_ranks(ranks))
                      : 0);
  };
  std::FILE* out = table_stream(options);
  Json counted = Json::array(), modelled = Json::array();
  if (!options.quiet)
    fmt::print(out,
               "{}: {} directions, {:.3g} walks each: {:.3g} s of processor time, set up in {:.2g} "
               "s, sums of {} ranks reduced in {:.2g} s\n\ncounted\n  ranks  messages  bytes of "
               "sums  bytes per walk\n",
               run.stack.name, directions, static_cast<double>(options.walks), work, found.setup,
               kMostCounted, found.reduction);
  for (const auto& [ranks, bytes] : found.bytes) {
    if (!options.quiet)
      fmt::print(out, "  {:>5}  {:>8}  {:>13}  {:>14.2e}\n", ranks, messages_of_ranks(ranks), bytes,
                 static_cast<double>(bytes) / walks);
    counted.push_back({{"ranks", ranks},
                       {"messages", messages_of_ranks(ranks)},
                       {"bytes", bytes},
                       {"bytes_per_walk", static_cast<double>(bytes) / walks}});
  }
  if (!options.quiet)
    fmt::print(out, "\nmodel: messages of {:g} us, {:g} GB/s\n  ranks   seconds  efficiency\n",
               1e6 * kLatency, 1e-9 * kBytesPerSecond);
  const auto add = [&](int ranks) {
    const double efficiency = seconds(1) / (ranks * seconds(ranks));
    if (!options.quiet)
      fmt::print(out, "  {:>5}  {:>8.3g}  {:>8.1f} %\n", ranks, seconds(ranks), 100 * efficiency);
    modelled.push_back({{"ranks", ranks}, {"seconds", seconds(ranks)}, {"efficiency", efficiency}});
  };
  for (int ranks = 1; ranks < kMostModelled; ranks *= 2) add(ranks);
  add(1000);
  Json answer = json_header("scaling", request);
  answer["walks"] = options.walks;
  answer["directions"] = directions;
  answer["seconds_per_walk"] = found.seconds_per_walk;
  answer["setup"] = found.setup;
  answer["reduction"] = found.reduction;
  answer["counted"] = std::move(counted);
  answer["model"] = std::move(modelled);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
