#include "compare/request/stopwatch.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <numeric>

namespace lamella {

double seconds_of(const std::function<void()>& f) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double start = now();
  f();
  return now() - start;
}

double wall_seconds_of(const std::function<void()>& f) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  f();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double InterleavedTimes::total_first() const {
  return std::accumulate(first.begin(), first.end(), 0.0);
}

double InterleavedTimes::median_ratio() const {
  std::vector<double> ratios;
  for (std::size_t k = 0; k < first.size(); ++k) ratios.push_back(second[k] / first[k]);
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

InterleavedTimes interleave(int repetitions, const std::function<void()>& first,
                            const std::function<void()>& second,
                            double (*clock)(const std::function<void()>&)) {
  InterleavedTimes times;
  for (int k = 0; k < repetitions; ++k) {
    times.first.push_back(clock(first));
    times.second.push_back(clock(second));
  }
  return times;
}

}  // namespace lamella
