#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "compare/bench/benchmark.h"
#include "compare/bench/walk_timing.h"
#include "volume/run/sample_run.h"

namespace lamella {
namespace {

void measure_kept_walks(const BenchmarkStack& stack, const BenchmarkEffort& effort,
                        std::uint64_t seed, const ReportRow& report) {
  const Stack walked = stack.stack();
  Plan plan = make_plan(walked);
  plan.isa = effort.isa;
  const SampleRun run(walked, plan, benchmark_incident(), seed);
  Simulation counted(walked, plan, benchmark_incident(), Estimator::analog, CellGrid{}, seed);
  std::uint64_t chunk = 0, kept = 0, rows = 0;
  const std::uint64_t all = std::uint64_t{1} << 48;
  const auto keep = [&](std::uint64_t n) {
    for (std::uint64_t begun = 0; begun < n;) {
      const WalkSamples samples = run.take(chunk++, all);
      begun += samples.walks;
      kept += samples.walks;
      rows += samples.count();
    }
  };
  const auto count = [&](std::uint64_t n) { counted.advance(counted.walks() + n); };
  // Whole chunks, on both sides.
  std::uint64_t walks = calibrate(effort.repetition_seconds, count);
  walks = (walks + run.chunk_walks() - 1) / run.chunk_walks() * run.chunk_walks();
  const std::uint64_t before = kept;
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { keep(walks); }, [&] { count(walks); });
  BenchmarkRow row{.what = stack.name + "/samples", .kind = "walk"};
  row.seconds = times.total_first();
  row.baseline = "the same walks counted in cells";
  row.ratio_to_baseline = times.median_ratio();
  row.extra = {{"walks", kept},
               {"rows", rows},
               {"isa", to_text(run.isa())},
               {"walks_per_second", static_cast<double>(kept - before) / times.total_first()}};
  report(std::move(row));
}

}  // namespace

void measure_samples(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const BenchmarkStack& stack : benchmark_stacks())
    one.execute([&] { measure_kept_walks(stack, effort, seed, report); });
}

}  // namespace lamella
