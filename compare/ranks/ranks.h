#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lamella {

/// What another rank sent.
struct RankMessage {
  int from = 0;
  std::string bytes;
};

/// What was sent so far.
struct RankTraffic {
  std::uint64_t messages = 0, bytes = 0;
};

/// Bytes of one message of MPI: longer ones go in several.
inline constexpr std::uint64_t kMessageBytes = std::uint64_t{64} << 20;

/// The processes that do one run together, each with its rank from 0 to count - 1; rank 0 writes
/// what is written. All calls come from one thread at a time.
class Ranks {
 public:
  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  virtual ~Ranks() = default;

  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int count() const = 0;
  /// Ranks on this machine.
  [[nodiscard]] virtual int neighbours() const = 0;
  /// Returns once the bytes have been handed over. Messages between two ranks keep their order.
  virtual void send(int to, std::string_view bytes) = 0;
  /// A message that has arrived, from any rank.
  [[nodiscard]] virtual std::optional<RankMessage> poll() = 0;
  /// Waits for a message without using the processor.
  [[nodiscard]] RankMessage receive();
  [[nodiscard]] virtual RankTraffic traffic() const = 0;
  /// Ends the processes of all ranks with this status.
  [[noreturn]] virtual void abort(int status) = 0;
};

/// The ranks that mpirun (or srun) started this process among; nullptr where it is alone. Starts
/// MPI at the first call. Throws UsageError where mpirun started several processes of a build
/// without MPI, each of which would do all of the work.
[[nodiscard]] Ranks* started_ranks();
/// Ends MPI, where it was started: the last call of a process.
void finish_ranks();

/// A sleep between two looks for a message, longer each time, up to 2 ms.
class RankPause {
 public:
  void wait();

 private:
  int microseconds_ = 20;
};

}  // namespace lamella
