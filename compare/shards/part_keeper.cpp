#include "compare/shards/part_keeper.h"

#include <fmt/format.h>

#include <utility>

#include "compare/files/output_folder.h"
#include "compare/request/errors.h"
#include "volume/result/number_bytes.h"
#include "volume/run/saved_walks.h"

namespace lamella {
namespace {

// Of a checkpoint's time, at most one part in this many goes into writing.
constexpr double kWritingShare = 20;

}  // namespace

PartKeeper::PartKeeper(Shard shard, std::optional<Checkpoint> checkpoint, StoredPieces found,
                       const StopFlag* stop, std::function<void(const std::string&)> warn)
    : shard_(shard),
      checkpoint_(std::move(checkpoint)),
      pieces_(std::move(found)),
      stop_(stop),
      warn_(std::move(warn)),
      due_(Clock::now()) {
  if (checkpoint_)
    due_ += std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(checkpoint_->seconds));
}

RunKeeper::Found PartKeeper::begin(Simulation& simulation) {
  walking_ = next_++;
  const BatchRange range = shard_.batches(walking_);
  simulation.walk_only(range);
  const auto found = pieces_.find(walking_);
  if (found == pieces_.end()) return {};
  try {
    std::vector<bool> there;
    const SavedWalks saved =
        restore_walks(found->second.bytes(most_walk_bytes(simulation)), simulation, there);
    if (static_cast<int>(saved.batches.size()) != range.end - range.first)
      throw DamagedBytes("it has batches of another part");
    return {saved.done, saved.seconds};
  } catch (const DamagedBytes& error) {
    throw UsageError(fmt::format("{}: piece {}: {}; allowed: a checkpoint of this run",
                                 checkpoint_ ? checkpoint_->file.string() : "part", walking_,
                                 error.what()));
  }
}

bool PartKeeper::is_due() const { return checkpoint_ && Clock::now() >= due_; }

void PartKeeper::write(bool must) {
  const Clock::time_point start = Clock::now();
  try {
    write_part(checkpoint_->file, checkpoint_->header, pieces_);
    // From here on they are read from there; reading checks what was written.
    pieces_ = pieces_of(std::make_shared<const PartFile>(checkpoint_->file));
  } catch (const OutputError& error) {
    // The last checkpoint is whole, and walks are worth more than the next one.
    if (must) throw;
    if (warn_) warn_(fmt::format("no checkpoint: {}; the run goes on", error.what()));
  }
  const std::chrono::duration<double> took = Clock::now() - start;
  due_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                            std::max(checkpoint_->seconds, kWritingShare * took.count())));
}

void PartKeeper::put(std::uint64_t number, std::string bytes) {
  pieces_.insert_or_assign(number, StoredPiece(std::move(bytes)));
}

void PartKeeper::save() {
  if (checkpoint_) write(true);
}

void PartKeeper::checkpoint(const Simulation& simulation, double seconds, bool now) {
  if (!checkpoint_ || !(now || is_due())) return;
  put(walking_, save_walks(simulation, seconds, false));
  write(now);
}

void PartKeeper::end(const Simulation& simulation, double seconds) {
  put(walking_, save_walks(simulation, seconds, true));
  if (is_due()) write(false);
}

std::optional<std::string> PartKeeper::piece(const Make& make) {
  const std::uint64_t number = next_++;
  if (const auto found = pieces_.find(number); found != pieces_.end())
    return found->second.bytes(kMostPieceBytes);
  if (!shard_.has(number)) return std::nullopt;
  std::string bytes = make();
  if (!is_set(stop_)) {
    put(number, bytes);
    if (is_due()) write(false);
  }
  return bytes;
}

}  // namespace lamella
