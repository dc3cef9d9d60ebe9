#include <fmt/format.h>
#include <gnu/libc-version.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>

#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/files/content_hash.h"
#include "compare/files/folder_lock.h"
#include "compare/options/progress.h"
#include "compare/ranks/sent_pieces.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/shards/merged_keeper.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

constexpr char kGoOn[] = "go on";

using Json = nlohmann::ordered_json;

std::string checkpoint_of(const Options& options, const Shard& shard) {
  if (options.checkpoint.empty()) return {};
  return fmt::format("{}.{}-of-{}", options.checkpoint, shard.index, shard.count);
}

void tell(const Ranks& ranks, const std::vector<double>& seconds, std::uint64_t bytes) {
  const auto [least, most] = std::minmax_element(seconds.begin(), seconds.end());
  fmt::print(stderr,
             "lamella: {} ranks: {:.2f} to {:.2f} s of processor time each, {} messages, {:.3g} MB "
             "of sums\n",
             ranks.count(), *least, *most, messages_of_ranks(ranks.count()),
             1e-6 * static_cast<double>(bytes));
}

// Ranks find the parts, rank 0 the rest of the command.
int do_parts(const DividedCommand& command, const DividedRun& run, const RunMonitor& monitor,
             Ranks& ranks) {
  const Options& options = run.options;
  const Shard shard{static_cast<std::uint64_t>(ranks.rank()) + 1,
                    static_cast<std::uint64_t>(ranks.count())};
  const std::string checkpoint = checkpoint_of(options, shard);
  std::optional<FileLock> lock;
  if (!checkpoint.empty()) lock.emplace(checkpoint);
  PartWork work =
      find_part(command, run, shard, checkpoint, monitor, options.quiet || ranks.rank() != 0);
  const auto remove_checkpoint = [&] {
    if (!checkpoint.empty()) fs::remove(checkpoint);
  };
  if (ranks.rank() != 0) {
    ranks.send(0, sent_pieces(loaded(work.pieces)));
    (void)ranks.receive();  // rank 0 has written
    remove_checkpoint();
    return kDone;
  }
  std::vector<std::unique_ptr<Pieces>> parts;
  parts.push_back(std::make_unique<SentPieces>("rank 0", loaded(work.pieces)));
  std::vector<double> seconds{cpu_seconds()};
  std::uint64_t bytes = 0;
  for (int k = 1; k < ranks.count(); ++k) {
    RankMessage message = ranks.receive();
    bytes += message.bytes.size();
    ReceivedPieces received = received_pieces(message.bytes);
    seconds.push_back(received.seconds);
    parts.push_back(std::make_unique<SentPieces>(fmt::format("rank {}", message.from),
                                                 std::move(received.pieces)));
  }
  std::vector<const Pieces*> all;
  for (const auto& part : parts) all.push_back(part.get());
  MergedKeeper keeper(std::move(all));
  RunMonitor finishing = monitor;
  finishing.keeper = &keeper;
  const int status = command.finish(run, finishing);
  if (!options.quiet) tell(ranks, seconds, bytes);
  for (int k = 1; k < ranks.count(); ++k) ranks.send(k, kGoOn);
  remove_checkpoint();
  return status;
}

Json told_by_rank(const DividedRun& run) {
  const InputFiles inputs(run.stack, objects_among(model_requests(run.options)));
  Json told{{"command", run.command}};
  told.update(identity_of(run, inputs));
  return told;
}

}  // namespace

void agree_by_ranks(const Json& request, Ranks& ranks) {
  // The C library's sines are not the same in every version.
  Json own{{"version", LAMELLA_VERSION},
           {"program file", content_hash_of_file("/proc/self/exe")},
           {"C library", gnu_get_libc_version()}};
  own.update(request);
  if (ranks.rank() != 0) {
    ranks.send(0, own.dump());
    (void)ranks.receive();
    return;
  }
  for (int k = 1; k < ranks.count(); ++k) {
    const RankMessage message = ranks.receive();
    const Json other = Json::parse(message.bytes, nullptr, false);
    if (other != own)
      throw UsageError(
          fmt::format("rank {}: found another run than that of rank 0: {}; allowed: the same "
                      "command, files and program for all (on unlike machines --isa NAME)",
                      message.from, difference_of_settings(other, own)));
  }
  for (int k = 1; k < ranks.count(); ++k) ranks.send(k, kGoOn);
}

void refuse_shard_of_ranks(const Options& options) {
  if (!options.shard.empty())
    throw UsageError(
        "--shard: found it under mpirun, whose ranks are the parts; allowed: one of "
        "the two");
}

RunMonitor monitor_of_rank(const Options& options, const Ranks& ranks) {
  RunMonitor monitor = terminal_monitor(options);
  // mpirun ends ranks by this one where another has died, or at Ctrl-C.
  std::signal(SIGTERM, [](int) { user_interrupt = true; });
  if (ranks.rank() != 0) monitor = {.stop = monitor.stop};
  return monitor;
}

int do_by_ranks(const DividedCommand& command, const DividedRun& run, Ranks& ranks) {
  refuse_shard_of_ranks(run.options);
  try {
    command.check(run);
  } catch (const UsageError& error) {
    // What a part cannot do, a rank cannot.
    const std::string text = error.what();
    constexpr std::string_view kShard = "--shard: ";
    throw UsageError(text.starts_with(kShard) ? "mpirun: " + text.substr(kShard.size()) : text);
  }
  const RunMonitor monitor = monitor_of_rank(run.options, ranks);
  agree_by_ranks(told_by_rank(run), ranks);
  return command.by_ranks ? command.by_ranks(run, monitor, ranks)
                          : do_parts(command, run, monitor, ranks);
}

}  // namespace lamella
