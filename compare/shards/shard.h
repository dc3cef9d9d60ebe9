#pragma once

#include <cstdint>
#include <string>

#include "volume/run/simulation.h"

namespace lamella {

/// The part `index` of `count` parts of a run, from 1; 1 of 1 is the whole run.
///
/// A run is a sequence of pieces, numbered from 0. The walks of a piece are divided by batches:
/// each part has a range of neighbouring batches of every piece, another range of each, so that
/// parts are of one size where a piece does not divide evenly. A piece that is no walk belongs to
/// one part as a whole, in turns.
struct Shard {
  std::uint64_t index = 1, count = 1;

  [[nodiscard]] bool is_divided() const { return count > 1; }
  [[nodiscard]] BatchRange batches(std::uint64_t piece) const;
  [[nodiscard]] bool has(std::uint64_t piece) const { return piece % count == index - 1; }
  /// "2/4"
  [[nodiscard]] std::string text() const;
  friend bool operator==(const Shard&, const Shard&) = default;
};

/// The most parts of a run.
inline constexpr std::uint64_t kMostShards = 1000000;

/// Bytes of a piece that is no walk at most: a solved run, the answer of a sweep's point.
inline constexpr std::uint64_t kMostPieceBytes = std::uint64_t{256} << 20;
/// What the batches of a simulation take at most as bytes: their sums, and what lanes need to go
/// on.
[[nodiscard]] std::uint64_t most_walk_bytes(const Simulation& simulation);

/// --shard: I/N. Throws UsageError.
[[nodiscard]] Shard parse_shard(const std::string& text);

}  // namespace lamella
