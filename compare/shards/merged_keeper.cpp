#include "compare/shards/merged_keeper.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "compare/request/errors.h"
#include "compare/shards/shard.h"
#include "volume/result/number_bytes.h"
#include "volume/run/saved_walks.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

Shard shard_of(const PartFile& part) {
  const Json& list = part.header().value("part", Json());
  if (list.is_array() && list.size() == 2 && list[0].is_number_unsigned() &&
      list[1].is_number_unsigned()) {
    const Shard shard{list[0].get<std::uint64_t>(), list[1].get<std::uint64_t>()};
    if (shard.index >= 1 && shard.index <= shard.count && shard.count <= kMostShards) return shard;
  }
  part.refuse("its header does not say which part it is");
}

// "2, 5 and 7"
std::string listed_numbers(const std::vector<std::uint64_t>& numbers) {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t k = 0; k < std::min(numbers.size(), kShown); ++k)
    text += fmt::format("{}{}", k == 0 ? "" : k + 1 == numbers.size() ? " and " : ", ", numbers[k]);
  if (numbers.size() > kShown) text += fmt::format(" and {} more", numbers.size() - kShown);
  return text;
}

}  // namespace

RunKeeper::Found MergedKeeper::begin(Simulation& simulation) {
  const std::uint64_t number = next_++;
  std::vector<bool> there(kBatches);
  std::optional<std::uint64_t> walks;
  Found found{.done = true};
  for (const Pieces* part : parts_) {
    if (!part->has(number)) continue;
    try {
      const SavedWalks saved =
          restore_walks(part->piece(number, most_walk_bytes(simulation)), simulation, there);
      if (!saved.done) throw DamagedBytes("its walks are not done");
      if (walks && *walks != saved.walks)
        throw DamagedBytes(fmt::format("it has {} walks, others {}", saved.walks, *walks));
      walks = saved.walks;
      found.seconds += saved.seconds;
    } catch (const DamagedBytes& error) {
      part->refuse(fmt::format("piece {}: {}", number, error.what()));
    }
  }
  if (!std::all_of(there.begin(), there.end(), [](bool is_there) { return is_there; }))
    throw UsageError(
        fmt::format("piece {}: found {} of {} batches in all parts; allowed: parts that lamella "
                    "wrote",
                    number, std::count(there.begin(), there.end(), true), kBatches));
  return found;
}

std::optional<std::string> MergedKeeper::piece(const Make&) {
  const std::uint64_t number = next_++;
  const Pieces* owner = nullptr;
  for (const Pieces* part : parts_) {
    if (!part->has(number)) continue;
    if (owner)
      part->refuse(fmt::format("found piece {} in it, which {} has", number, owner->name()));
    owner = part;
  }
  if (!owner)
    throw UsageError(
        fmt::format("piece {}: found in no part; allowed: parts that lamella wrote", number));
  return owner->piece(number, kMostPieceBytes);
}

std::string difference_of_settings(const Json& there, const Json& asked) {
  constexpr std::size_t kShort = 60;
  for (const auto& [key, value] : asked.items()) {
    const Json other = there.is_object() ? there.value(key, Json()) : Json();
    if (other == value) continue;
    const std::string was = other.dump(), is = value.dump();
    return was.size() > kShort || is.size() > kShort
               ? fmt::format("its {} differs", key)
               : fmt::format("its {} is {} instead of {}", key, was, is);
  }
  return "it has settings that are unknown here";
}

void check_parts(const std::vector<std::unique_ptr<PartFile>>& parts) {
  const PartFile& first = *parts.front();
  const Shard of = shard_of(first);
  std::map<std::uint64_t, const PartFile*> there;
  for (const auto& part : parts) {
    if (part->header().value("checkpoint", Json()) != Json(false))
      part->refuse("found the checkpoint of a run that did not end");
    if (const std::string version = part->text("version"); version != LAMELLA_VERSION)
      throw UsageError(
          fmt::format("{}: found a part that lamella {} wrote, whose numbers may differ; allowed: "
                      "parts of lamella {}, which this is",
                      part->path().string(), version, LAMELLA_VERSION));
    if (part->text("command") != first.text("command"))
      throw UsageError(
          fmt::format("{}: found a part of {}, and {} is one of {}; allowed: parts of "
                      "one run",
                      part->path().string(), part->text("command"), first.path().string(),
                      first.text("command")));
    const Json& settings = part->header().value("settings", Json());
    if (const Json& others = first.header().value("settings", Json()); settings != others)
      throw UsageError(fmt::format(
          "{}: found a part of another run than {}: {}; allowed: parts of one run",
          part->path().string(), first.path().string(), difference_of_settings(settings, others)));
    const Shard shard = shard_of(*part);
    if (shard.count != of.count)
      throw UsageError(fmt::format("{}: found part {}, and {} is {}; allowed: parts of one run",
                                   part->path().string(), shard.text(), first.path().string(),
                                   of.text()));
    if (const auto [other, is_new] = there.try_emplace(shard.index, part.get()); !is_new)
      throw UsageError(fmt::format("{}: found part {}, which {} is, too; allowed: every part once",
                                   part->path().string(), shard.text(),
                                   other->second->path().string()));
  }
  std::vector<std::uint64_t> missing;
  for (std::uint64_t k = 1; k <= of.count; ++k)
    if (!there.contains(k)) missing.push_back(k);
  if (!missing.empty())
    throw UsageError(fmt::format("found {} of {} parts: {} {} missing; allowed: every part once",
                                 there.size(), of.count, listed_numbers(missing),
                                 missing.size() == 1 ? "is" : "are"));
}

}  // namespace lamella
