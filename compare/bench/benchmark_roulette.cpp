#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "compare/bench/benchmark.h"
#include "compare/bench/textbook_walk.h"
#include "compare/request/stopwatch.h"

namespace lamella {
namespace {

constexpr int kNever = 1 << 20;  // weights until nothing is left of them

// Seconds to an error of 1 % of the reflected cells, by time x variance. Walks are independent: the
// variance is that of one of them.
double seconds_to_a_percent(TextbookWalk& walk, double seconds) {
  double taken = 0;
  for (std::uint64_t walks = 1 << 14; taken < seconds; walks *= 2)
    taken += seconds_of([&] { walk.advance(walks); });
  const TextbookResult& found = walk.result();
  const double n = static_cast<double>(found.walks);
  double noise = 0, signal = 0;
  for (std::size_t j = 0; j < found.f.size(); ++j) {
    const double mean = found.f[j] / n;
    noise += (found.f2[j] / n - mean * mean) / n;
    signal += mean * mean;
  }
  return taken * 1e4 * noise / signal;
}

}  // namespace

void measure_roulette(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const BenchmarkStack& stack : benchmark_stacks()) {
    double engine = 0;
    for (const int weighted : {3, 0, 15, kNever}) {
      TextbookCase what = stack.textbook;
      what.weighted_events = weighted;
      TextbookWalk walk(what, benchmark_incident(), TextbookTally::cells, {}, seed);
      const double seconds =
          one.execute([&] { return seconds_to_a_percent(walk, effort.accuracy_seconds / 2); });
      const std::string when =
          weighted == kNever ? "never" : fmt::format("from event {} on", weighted + 1);
      BenchmarkRow row{.what = fmt::format("roulette/{}/{}", stack.name, when), .kind = "walk"};
      row.seconds = seconds;
      row.error = 0.01;
      row.extra["walks"] = walk.result().walks;
      if (weighted == 3) {
        engine = seconds;
      } else {
        row.baseline = "from event 4 on, like the engine; the same textbook loop";
        row.ratio_to_baseline = engine / seconds;
      }
      report(std::move(row));
    }
  }
}

}  // namespace lamella
