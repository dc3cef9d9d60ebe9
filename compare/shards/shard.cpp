#include "compare/shards/shard.h"

#include <fmt/format.h>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"

namespace lamella {

BatchRange Shard::batches(std::uint64_t piece) const {
  const std::uint64_t place = (index - 1 + piece % count) % count;
  return {static_cast<int>(place * kBatches / count),
          static_cast<int>((place + 1) * kBatches / count)};
}

std::uint64_t most_walk_bytes(const Simulation& simulation) {
  const std::uint64_t sums = simulation.batches().front().f.size();
  return kBatches * (sums * 2 * sizeof(double) + 4096) + 4096;
}

std::string Shard::text() const { return fmt::format("{}/{}", index, count); }

Shard parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash != std::string::npos) {
    const auto index = parse_whole_number(text.substr(0, slash));
    const auto count = parse_whole_number(text.substr(slash + 1));
    if (index && count && *index >= 1 && *index <= *count && *count <= kMostShards)
      return {*index, *count};
  }
  throw UsageError(
      fmt::format("--shard: found \"{}\"; allowed: I/N, the part I of N parts, I from 1 to N, N up "
                  "to {}",
                  text, kMostShards));
}

}  // namespace lamella
