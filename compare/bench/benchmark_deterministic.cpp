#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <optional>

#include "compare/bench/benchmark.h"
#include "compare/request/stopwatch.h"
#include "compare/truth/point_truth.h"
#include "phase/random/random.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "volume/harmonics/harmonic_run.h"
#include "volume/plan/plan.h"
#include "volume/solver/deterministic_run.h"
#include "volume/solver/pair_table.h"

namespace lamella {
namespace {

// One stack per medium and flake, so that each kernel shows what it costs.
struct SolvedStack {
  std::string name, toml;
};
const std::vector<SolvedStack>& solved_stacks() {
  static const std::vector<SolvedStack> list{
      {"lambert_sphere_halfspace", "medium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = inf\n"},
      {"lambert_sphere_slab", "medium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = 2\n"},
      {"hg_slab", "medium = \"henyey_greenstein\"\ng = 0.7\nalbedo = 0.9\nthickness = 4\n"},
      {"sggx_lambert_slab",
       "medium = \"sggx\"\nflake = \"lambert\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 2\n"},
      {"sggx_slab", "medium = \"sggx\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 2\n"},
      {"vmf_halfspace", "medium = \"vmf_flake\"\nroughness = 0.5\nalbedo = 0.9\nthickness = inf\n"},
      // The hard ends of the range.
      {"hg_0.9_slab", "medium = \"henyey_greenstein\"\ng = 0.9\nalbedo = 0.9\nthickness = 4\n"},
      {"sggx_lambert_0.05_slab",
       "medium = \"sggx\"\nflake = \"lambert\"\nroughness = 0.05\nalbedo = 0.9\nthickness = 2\n"},
      {"vmf_lambert_0.01_slab",
       "medium = \"vmf_flake\"\nroughness = 0.01\nalbedo = 0.9\nthickness = 2\n"},
      {"sggx_mirror_0.3_slab", "medium = \"sggx\"\nroughness = 0.3\nalbedo = 0.9\nthickness = 2\n"},
      {"vmf_mirror_0.3_halfspace",
       "medium = \"vmf_flake\"\nflake = \"mirror\"\nroughness = 0.3\nalbedo = 0.9\nthickness = "
       "inf\n"},
      {"sggx_mirror_0.05_slab",
       "medium = \"sggx\"\nroughness = 0.05\nalbedo = 0.9\nthickness = 2\n"},
  };
  return list;
}

Stack stack_of(const SolvedStack& s) { return parse_stack("[[layer]]\n" + s.toml, s.name, s.name); }

BenchmarkRow row_of(std::string what, double seconds, const DeterministicAccuracy& a) {
  BenchmarkRow row{.what = std::move(what), .kind = "deterministic"};
  row.seconds = seconds;
  row.error = a.error;
  row.extra = {{"nodes", a.nodes}, {"modes", a.modes}, {"bytes", a.bytes}, {"reached", a.reached}};
  return row;
}

// Seconds against digits reached, per medium.
void measure_digits(bool quick, double seconds_allowed, Isa isa, const ReportRow& report) {
  for (const SolvedStack& solved : solved_stacks())
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
      if (quick && tolerance < 1e-4) continue;
      const Stack stack = stack_of(solved);
      DeterministicAccuracy accuracy;
      const double seconds = seconds_of([&] {
        accuracy = solve_deterministic(
                       stack, {.tolerance = tolerance, .max_seconds = seconds_allowed, .isa = isa})
                       .accuracy();
      });
      report(row_of(fmt::format("{}/solve/{:.0e}", solved.name, tolerance), seconds, accuracy));
    }
}

// Stacks without symmetry about the normal: seconds against digits of all cells of a 16 x 32 grid
// for one direction.
void measure_harmonics(bool quick, double seconds_allowed, Isa isa, const ReportRow& report) {
  const std::vector<SolvedStack> list{
      {"fibers_lambert_0.5_slab",
       "medium = \"sggx\"\nshape = \"fiber\"\nflake = \"lambert\"\nroughness = 0.5\nalbedo = 0.9\n"
       "thickness = 1\n"},
      {"fibers_0.5_slab",
       "medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 1\n"},
      {"fibers_0.3_slab",
       "medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.3\nalbedo = 0.9\nthickness = 1\n"},
      {"leaning_vmf_0.5_slab",
       "medium = \"vmf_flake\"\naxis = [1, 0, 1]\nroughness = 0.5\nalbedo = 0.9\nthickness = 1\n"},
      {"leaning_sggx_0.5_halfspace",
       "medium = \"sggx\"\naxis = [1, 0, 1]\nflake = \"lambert\"\nroughness = 0.5\nalbedo = 0.9\n"
       "thickness = inf\n"},
      {"fibers_0.1_slab",
       "medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.1\nalbedo = 0.9\nthickness = 1\n"},
      // Below a smooth and a rough coat.
      {"fibers_lambert_0.5_slab/smooth_coat",
       "interface = \"smooth\"\nior = 1.5\n[[layer]]\nmedium = \"sggx\"\nshape = \"fiber\"\n"
       "flake = \"lambert\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 1\n"},
      {"fibers_lambert_0.5_slab/rough_coat",
       "interface = \"ggx\"\nior = 1.5\nroughness = 0.3\n[[layer]]\nmedium = \"sggx\"\n"
       "shape = \"fiber\"\nflake = \"lambert\"\nroughness = 0.5\nalbedo = 0.9\nthickness = 1\n"}};
  const Direction incident[] = {direction_from_degrees(45, 0)};
  for (const SolvedStack& solved : list)
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      if (quick && tolerance < 1e-2) continue;
      const Stack stack = stack_of(solved);
      std::vector<RunResult> runs;
      const double seconds = seconds_of([&] {
        runs = harmonic_runs(stack, make_plan(stack), incident, CellGrid{16, 32},
                             {.tolerance = tolerance, .max_seconds = seconds_allowed, .isa = isa});
      });
      const DeterministicAccuracy& reached = *runs.front().accuracy;
      BenchmarkRow row =
          row_of(fmt::format("{}/harmonics/{:.0e}", solved.name, tolerance), seconds, reached);
      row.extra["degree"] = reached.harmonics;
      report(std::move(row));
    }
}

// The cells of the rows below, of a 32 x 32 grid for eight incident directions.
std::vector<RunResult> all_cells(const Stack& stack, const Plan& plan, double tolerance, Isa isa) {
  std::vector<Direction> incident;
  for (int k = 0; k < 8; ++k) incident.push_back(direction_from_degrees(10.0 * k, 0));
  return deterministic_runs(solve_deterministic(stack, {.tolerance = tolerance / 2, .isa = isa}),
                            plan, incident, CellGrid{32, 32, true}, tolerance);
}

// Their time, beside that which walks would need for the same error, from their time x variance.
void measure_cells(bool quick, double tolerance, std::uint64_t seed, Isa isa,
                   const ReportRow& report) {
  const Stack stack = stack_of(solved_stacks().front());
  const Plan plan = make_plan(stack);
  std::vector<RunResult> runs;
  const double seconds = seconds_of([&] { runs = all_cells(stack, plan, tolerance, isa); });
  double worst = 0;
  for (const RunResult& run : runs) worst = std::max(worst, run.accuracy->error);
  DeterministicAccuracy accuracy = *runs.front().accuracy;
  accuracy.error = worst;
  accuracy.reached = worst <= tolerance;
  BenchmarkRow row =
      row_of(fmt::format("lambert_sphere_halfspace/cells 32x32, 8 directions/{:.0e}", tolerance),
             seconds, accuracy);
  Simulation walks(stack, plan, benchmark_incident(), Estimator::analog, CellGrid{32, 32, true},
                   seed);
  const double walk_seconds = seconds_of([&] { walks.advance(quick ? 1 << 12 : 1 << 17); });
  const RunResult walked = reduce(walks);
  const LobeEstimate& all = walked.reflected.lobes[Order::all];
  double noise = 0, signal = 0;
  for (std::size_t k = 0; k < all.value.size(); ++k) {
    noise += all.standard_error[k] * all.standard_error[k];
    signal += all.value[k] * all.value[k];
  }
  row.baseline = "analog walks to the same error";
  row.ratio_to_baseline = 8 * walk_seconds * noise / signal / (worst * worst) / seconds;
  row.extra["extrapolated"] = true;
  report(std::move(row));
}

// f at scattered pairs of directions, the solution with them, against finding it pair by pair.
void measure_pairs(bool quick, double tolerance, std::uint64_t seed, Isa isa,
                   const ReportRow& report) {
  const std::size_t count = quick ? 10000 : 1000000, few = quick ? 8 : 256;
  const Stack stack = stack_of(solved_stacks().front());
  RandomStream random(seed, 0, StreamPurpose::walk);
  std::vector<DirectionPair> pairs;
  std::vector<CosinePair> cosines;
  for (std::size_t k = 0; k < count; ++k) {
    const double mu_i = random.uniform(), mu_o = random.uniform();
    pairs.push_back(
        {direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, 2 * kPi * random.uniform())});
    cosines.push_back({mu_i, mu_o});
  }
  std::optional<DeterministicSolution> solution;
  const double seconds = seconds_of([&] {
    solution = solve_deterministic(stack, {.tolerance = tolerance / 2, .isa = isa});
    (void)truth_at(*solution, pairs);
  });
  pairs.resize(few);
  const double each =
      seconds_of([&] { (void)truth_at(*solution, pairs); }) / static_cast<double>(few);
  BenchmarkRow row = row_of(fmt::format("lambert_sphere_halfspace/1e6 pairs/{:.0e}", tolerance),
                            seconds, solution->accuracy());
  row.baseline = fmt::format("pair by pair, from {} of them", few);
  row.ratio_to_baseline = each * static_cast<double>(count) / seconds;
  if (const auto table = PairTable::make(*solution, cosines)) {
    row.extra["rows"] = table->outgoing();
    row.extra["columns"] = table->incident();
  }
  report(std::move(row));
}

// The cells above to 1e-8 by one thread and by all, by the clock.
void measure_solver_threads(const BenchmarkEffort& effort, const ReportRow& report) {
  constexpr double kTolerance = 1e-8;
  const Stack stack = stack_of(solved_stacks().front());
  const Plan plan = make_plan(stack);
  std::vector<RunResult> runs;
  const auto solve = [&] { runs = all_cells(stack, plan, kTolerance, effort.isa); };
  tbb::task_arena one(1), all;
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { all.execute(solve); }, [&] { one.execute(solve); },
      wall_seconds_of);
  BenchmarkRow row = row_of("lambert_sphere_halfspace/cells, threads/1e-08",
                            times.total_first() / effort.repetitions, *runs.front().accuracy);
  row.baseline = "one thread";
  row.ratio_to_baseline = times.median_ratio();
  row.extra["threads"] = all.max_concurrency();
  report(std::move(row));
}

// How the cost of one solution grows: seconds at the largest size, and the exponent from half of
// it.
void measure_growth(bool quick, Isa isa, const ReportRow& report) {
  const Stack stack = stack_of(solved_stacks()[2]);
  const auto solve = [isa](const Stack& s, int nodes, int modes, DeterministicAccuracy& accuracy) {
    // A tolerance that no series of modes ends at.
    return seconds_of([&] {
      accuracy = solve_deterministic(s, {.tolerance = 1e-30,
                                         .min_nodes = nodes,
                                         .max_nodes = nodes,
                                         .max_modes = modes,
                                         .isa = isa})
                     .accuracy();
    });
  };
  const auto grow = [&](const std::string& what, int from, int to, const auto& seconds_at) {
    DeterministicAccuracy accuracy;
    double before = 0;
    for (int n = from; n <= to; n *= 2) {
      const double seconds = seconds_at(n, accuracy);
      BenchmarkRow row = row_of(fmt::format("growth/{} {}", what, n), seconds, accuracy);
      // Refinement was switched off: there is no error to tell.
      row.error.reset();
      row.extra.erase("reached");
      if (before > 0) row.extra["exponent"] = std::log2(seconds / before);
      before = seconds;
      report(std::move(row));
    }
  };
  grow("nodes", 8, quick ? 16 : 64,
       [&](int n, DeterministicAccuracy& a) { return solve(stack, n, 8, a); });
  grow("modes", 8, quick ? 16 : 64,
       [&](int n, DeterministicAccuracy& a) { return solve(stack, 16, n, a); });
  grow("layers", 1, quick ? 4 : 32, [&](int n, DeterministicAccuracy& a) {
    std::string toml;
    for (int k = 0; k < n; ++k)
      toml += fmt::format("[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = 0.9\nthickness = {}\n",
                          1 + 0.01 * k);
    return solve(parse_stack(toml, "layers", "layers"), 16, 8, a);
  });
}

}  // namespace

void measure_deterministic(const BenchmarkEffort& effort, std::uint64_t seed,
                           const ReportRow& report) {
  const bool quick = effort.repetition_seconds < 0.05;
  tbb::task_arena one(1);
  one.execute([&] {
    measure_digits(quick, effort.solver_seconds, effort.isa, report);
    measure_harmonics(quick, effort.solver_seconds, effort.isa, report);
    for (const double tolerance : {1e-6, 1e-8})
      measure_cells(quick, tolerance, seed, effort.isa, report);
    for (const double tolerance : {1e-4, 1e-6})
      measure_pairs(quick, tolerance, seed, effort.isa, report);
    measure_growth(quick, effort.isa, report);
  });
  measure_solver_threads(effort, report);
}

}  // namespace lamella
