#include "compare/bench/bench_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "phase/stack/text_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLeastNoise = 0.05;
constexpr std::size_t kMostBytes = std::size_t{1} << 24;

// Keys whose numbers are times or speeds of the machine at hand.
constexpr const char* kMeasured[] = {"seconds",
                                     "collisions_per_second_per_core",
                                     "ns_per_eval",
                                     "ratio_to_baseline",
                                     "walks_per_second",
                                     "cycles_per_walk",
                                     "cycles_per_collision",
                                     "baseline_collisions_per_second",
                                     "ns_textbook",
                                     "rays_per_second",
                                     "exponent",
                                     "directions_per_second",
                                     "closed_seconds",
                                     "ratio_to_random",
                                     "processor_seconds",
                                     "least_seconds"};

std::optional<double> positive(const Json& row, const char* key) {
  const auto found = row.find(key);
  if (found == row.end() || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return std::isfinite(value) && value > 0 ? std::optional(value) : std::nullopt;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

const Json* row_named(const Json& rows, const Json& what) {
  for (const Json& row : rows)
    if (row.at("what") == what) return &row;
  return nullptr;
}

double spread_of(const Json& row) {
  const auto found = row.find("spread");
  return found != row.end() && found->is_number() ? found->get<double>() : 0;
}

}  // namespace

std::optional<RowSpeed> speed_of(const Json& row) {
  for (const char* key : {"ratio_to_baseline", "collisions_per_second_per_core"})
    if (const auto value = positive(row, key)) return RowSpeed{key, *value};
  for (const char* key : {"ns_per_eval", "processor_seconds", "seconds"})
    if (const auto value = positive(row, key)) return RowSpeed{key, 1 / *value};
  return std::nullopt;
}

Json combined_rounds(const std::vector<Json>& rounds) {
  Json combined = Json::array();
  if (rounds.empty()) return combined;
  if (rounds.size() == 1) return rounds.front();
  for (const Json& first : rounds.front()) {
    std::vector<const Json*> rows;
    for (const Json& round : rounds)
      if (const Json* row = row_named(round, first.at("what"))) rows.push_back(row);
    if (rows.size() < rounds.size()) continue;
    Json row = first;
    for (const char* key : kMeasured) {
      std::vector<double> values;
      for (const Json* one : rows)
        if (one->contains(key) && one->at(key).is_number())
          values.push_back(one->at(key).get<double>());
      if (values.size() == rows.size()) row[key] = median(values);
    }
    std::vector<double> speeds;
    for (const Json* one : rows)
      if (const auto speed = speed_of(*one)) speeds.push_back(speed->value);
    if (speeds.size() == rows.size()) {
      const auto [low, high] = std::minmax_element(speeds.begin(), speeds.end());
      row["spread"] = 0.5 * (*high - *low) / median(speeds);
    }
    combined.push_back(std::move(row));
  }
  return combined;
}

std::vector<BenchChange> changes_between(const Json& before, const Json& now) {
  std::vector<BenchChange> changes;
  for (const Json& row : now) {
    const auto speed = speed_of(row);
    if (!speed) continue;
    BenchChange change{.what = row.at("what").get<std::string>(),
                       .measure = speed->measure,
                       .now = row.at(speed->measure).get<double>()};
    if (const Json* old = row_named(before, row.at("what")))
      if (const auto was = speed_of(*old); was && was->measure == speed->measure) {
        change.before = old->at(speed->measure).get<double>();
        change.ratio = speed->value / was->value;
        change.noise = std::max(kLeastNoise, spread_of(row) + spread_of(*old));
      }
    changes.push_back(std::move(change));
  }
  for (const Json& row : before)
    if (const auto speed = speed_of(row); speed && !row_named(now, row.at("what")))
      changes.push_back({.what = row.at("what").get<std::string>(),
                         .measure = speed->measure,
                         .before = row.at(speed->measure).get<double>()});
  return changes;
}

Json read_bench_file(const std::string& file, const std::string& isa, bool quick) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(
        fmt::format("--against {}: {}; allowed: a file that lamella bench "
                    "--json wrote",
                    file, why));
  };
  std::string text;
  try {
    text = read_text_file(file, kMostBytes);
  } catch (const TextFileError& error) {
    refuse(error.what());
  }
  const Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded() || !value.is_object()) refuse("is no JSON");
  if (value.value("command", Json()) != Json("bench") || !value.contains("rows") ||
      !value["rows"].is_array())
    refuse("is no result of bench");
  for (const Json& row : value["rows"])
    if (!row.is_object() || !row.contains("what") || !row["what"].is_string())
      refuse("has a row without a name");
  if (value.value("isa", Json()) != Json(isa))
    refuse(fmt::format("was measured with isa {}, this run has {} (see --isa)",
                       value.value("isa", Json()).dump(), isa));
  if (value.value("quick", Json()) != Json(quick))
    refuse(quick ? "was measured without --quick" : "was measured with --quick");
  return value["rows"];
}

}  // namespace lamella
