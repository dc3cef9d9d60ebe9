#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "compare/request/run_keeper.h"
#include "compare/shards/part_file.h"
#include "compare/shards/shard.h"

namespace lamella {

/// Seconds between two checkpoints, where nothing else is asked for.
inline constexpr double kCheckpointSeconds = 60;

/// Where and how often a run leaves its pieces, to go on from there.
struct Checkpoint {
  std::filesystem::path file;
  double seconds = kCheckpointSeconds;  ///< between two of them; more where writing takes long
  nlohmann::ordered_json header{};
};

/// Finds a part of a run, the whole run among them, and keeps its pieces.
class PartKeeper : public RunKeeper {
 public:
  /// `found`: the pieces that an earlier run found. `stop`: once set, what is found is not whole.
  PartKeeper(Shard shard, std::optional<Checkpoint> checkpoint, StoredPieces found,
             const StopFlag* stop, std::function<void(const std::string&)> warn);

  [[nodiscard]] Found begin(Simulation& simulation) override;
  void checkpoint(const Simulation& simulation, double seconds, bool now) override;
  void end(const Simulation& simulation, double seconds) override;
  [[nodiscard]] std::optional<std::string> piece(const Make& make) override;

  /// Writes the checkpoint, if there is one, now. Throws OutputError.
  void save();
  /// All pieces so far; with a checkpoint, those that it holds are read from there.
  [[nodiscard]] const StoredPieces& pieces() const { return pieces_; }

 private:
  using Clock = std::chrono::steady_clock;
  void write(bool must);
  void put(std::uint64_t number, std::string bytes);
  [[nodiscard]] bool is_due() const;

  Shard shard_;
  std::optional<Checkpoint> checkpoint_;
  StoredPieces pieces_;
  const StopFlag* stop_;
  std::function<void(const std::string&)> warn_;
  std::uint64_t next_ = 0, walking_ = 0;  // numbers of pieces: the next, that of the walks
  Clock::time_point due_;
};

}  // namespace lamella
