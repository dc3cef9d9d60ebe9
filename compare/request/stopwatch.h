#pragma once

#include <functional>
#include <vector>

namespace lamella {

/// Seconds of processor time of the calling thread during one call; time that other programs take
/// does not count.
[[nodiscard]] double seconds_of(const std::function<void()>& f);

/// Seconds by the wall clock, for work in many threads.
[[nodiscard]] double wall_seconds_of(const std::function<void()>& f);

/// Seconds per repetition of two alternating programs.
struct InterleavedTimes {
  std::vector<double> first, second;
  [[nodiscard]] double total_first() const;
  /// Median over the repetitions of second / first: how many times faster the first is.
  [[nodiscard]] double median_ratio() const;
};
[[nodiscard]] InterleavedTimes interleave(
    int repetitions, const std::function<void()>& first, const std::function<void()>& second,
    double (*clock)(const std::function<void()>&) = seconds_of);

}  // namespace lamella
