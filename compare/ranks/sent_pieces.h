#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace lamella {

/// Seconds of processor time that this process took so far, the system's among them.
[[nodiscard]] double cpu_seconds();

/// What a rank sends to rank 0 once its part is found: its cpu_seconds(), and the pieces.
[[nodiscard]] std::string sent_pieces(const std::map<std::uint64_t, std::string>& pieces);
/// The pieces in it; `seconds`: the processor time. Throws DamagedBytes.
struct ReceivedPieces {
  double seconds = 0;
  std::map<std::uint64_t, std::string> pieces{};
};
[[nodiscard]] ReceivedPieces received_pieces(std::string_view bytes);

/// Messages of a run of walks in all: each of the other ranks tells what it was asked for, is told
/// to go on, sends its pieces (once per kMessageBytes) and is told that rank 0 has written.
[[nodiscard]] constexpr std::uint64_t messages_of_ranks(int count) {
  return 4 * static_cast<std::uint64_t>(count - 1);
}

}  // namespace lamella
