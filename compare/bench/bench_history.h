#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace lamella {

/// The rows of several rounds of the same benchmarks as one list, in the order of the first round:
/// every number of time or speed is the median over the rounds, and `spread` is half the distance
/// between the slowest and the fastest round relative to the median, of the number by which the row
/// is compared (speed_of). Rows are those that every round has; one round has no spread.
[[nodiscard]] nlohmann::ordered_json combined_rounds(
    const std::vector<nlohmann::ordered_json>& rounds);

/// The number that tells how fast a row is, larger is faster: its ratio to its baseline, which was
/// measured in the same run, else evaluations or collisions a second, else 1 / seconds, of the
/// processor where it has those. Nothing where the row has none of them.
struct RowSpeed {
  std::string measure;  ///< the key of the row that it comes from
  double value;
};
[[nodiscard]] std::optional<RowSpeed> speed_of(const nlohmann::ordered_json& row);

/// A row of two lists of measurements. Without a ratio: only one of them has it, or they are
/// measured by different numbers.
struct BenchChange {
  std::string what, measure;
  std::optional<double> before{}, now{};  ///< of `measure`
  std::optional<double> ratio{};          ///< of the speeds: above 1 it is faster now
  double noise = 0;                       ///< of the ratio, as a share of it

  [[nodiscard]] bool fell() const { return ratio && *ratio < 1 - noise; }
  [[nodiscard]] bool rose() const { return ratio && *ratio > 1 + noise; }
};

/// Row by row, in the order of `now`, then what only `before` has. The noise of a ratio is the sum
/// of both spreads, and at least 5 %.
[[nodiscard]] std::vector<BenchChange> changes_between(const nlohmann::ordered_json& before,
                                                       const nlohmann::ordered_json& now);

/// Reads what `lamella bench --json` wrote. Throws std::invalid_argument, its text one line, where
/// the file cannot be read or is something else; `isa` and `quick` must be those of this run, since
/// other kernels and shorter rounds are no ground for a comparison.
[[nodiscard]] nlohmann::ordered_json read_bench_file(const std::string& file,
                                                     const std::string& isa, bool quick);

}  // namespace lamella
