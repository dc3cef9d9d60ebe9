#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/bench/textbook_walk.h"
#include "compare/request/model_request.h"
#include "compare/request/stopwatch.h"
#include "volume/run/simulation.h"

namespace lamella {

/// One measurement, beside its baseline from the same run. What does not apply is absent.
struct BenchmarkRow {
  std::string what;
  std::string kind;  ///< walk, deterministic, closed_form, grains, startup
  std::optional<double> seconds{};
  std::optional<double> collisions_per_second_per_core{};
  std::optional<double> ns_per_eval{};
  std::optional<double> error{};              ///< relative standard error or bound reached
  std::string baseline{};                     ///< in words; empty: none
  std::optional<double> ratio_to_baseline{};  ///< above 1 is faster than the baseline
  nlohmann::ordered_json extra{};             ///< further keys, an object or null
};

/// The row with every key of the contract, null where absent, then the extra ones.
[[nodiscard]] nlohmann::ordered_json to_json(const BenchmarkRow& row);

/// How long to measure. Rates of two programs are compared by interleaved repetitions of the same
/// length, so that a change of the machine's speed meets both.
struct BenchmarkEffort {
  int repetitions = 5;
  double repetition_seconds = 0.12;  ///< of each walk and each baseline
  double evaluation_seconds = 0.01;  ///< of a closed form, per repetition
  double accuracy_seconds = 1.5;     ///< per stack and estimator
  /// Of the solver's rows of seconds against digits: a finer solution is begun only if it would end
  /// within them.
  double solver_seconds = 15;
  Isa isa = Isa::scalar;  ///< of the walks
  static BenchmarkEffort quick() { return {3, 0.01, 0.001, 0.05, 0.2}; }
};

/// Relative root mean square of the cells' standard errors.
[[nodiscard]] double noise_of(const LobeEstimate& lobe);

/// Advances by doubling numbers of walks until `seconds` have passed; returns the seconds taken.
double advance_for(Simulation& simulation, double seconds);

/// A stack of the walk rows and the textbook loop of the same physics.
struct BenchmarkStack {
  std::string name;
  TextbookCase textbook;
  std::string toml{};  ///< empty: a built-in stack
  [[nodiscard]] Stack stack() const;
};
/// Built-in stacks, one of each distribution.
[[nodiscard]] const std::vector<BenchmarkStack>& benchmark_stacks();
/// And one of every other medium that walks on lanes.
[[nodiscard]] std::vector<BenchmarkStack> benchmark_media();

/// The incident direction of all walk rows: theta_i = 60 degrees.
[[nodiscard]] Direction benchmark_incident();

/// `count` directions that cover the upper hemisphere evenly in mu and phi.
[[nodiscard]] std::vector<Direction> benchmark_points(int count);

using ReportRow = std::function<void(BenchmarkRow)>;

/// Walks of the stacks above: walk, walk+cells, nee1, nee16, nee64, against the textbook loops,
/// one thread.
void measure_walks(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// Walks that are counted in cells, with a rough coat over Lambert spheres and over Lambert's law,
/// against the textbook loop with a coat, one thread.
void measure_coats(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// Walks that are counted in cells, through vMF flakes of several widths that lean towards the
/// light, against the scalar kernel, one thread.
void measure_tilted_flakes(const BenchmarkEffort& effort, std::uint64_t seed,
                           const ReportRow& report);

/// Walks that are kept one by one (volume/run/sample_run.h), in memory, against the same walks
/// counted in cells, one thread.
void measure_samples(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// Seconds to 1 % standard error of lobes, and to 0.1 % and 0.01 % of those of all orders, by
/// estimator and by the solver, one thread.
void measure_accuracy(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// What Russian roulette does to time x variance: the textbook loops with it from event 1, 4, 16 on
/// and never, one thread.
void measure_roulette(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// What thinning long walks does to time x variance, of cells and of energies, where walks are
/// short and long: the ground for where the plan begins to, one thread.
void measure_thinning(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// What randomised quasi-Monte Carlo does to the variance of cells and energies, lobe by lobe, and
/// to time x variance, with 1e4 walks and more; one thread.
void measure_sampling(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// What order 1 in closed form does to time x variance of all orders, cells and energies, of 1e6
/// walks; the closed form's time is part of it; one thread.
void measure_order_one(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// What weighing the analog and the next-event estimator against each other in every cell could
/// save at best, one thread.
void measure_combination(const BenchmarkEffort& effort, std::uint64_t seed,
                         const ReportRow& report);

/// Cost per value of the reflected lobe against its error, on the stacks of the walk rows: each
/// estimator of walks at growing numbers of them, the solver at falling tolerances, and the closed
/// forms that apply; one thread.
void measure_tradeoff(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// The solver: seconds and memory against digits reached, all cells of a grid, f at very many pairs
/// of directions, growth of the cost with nodes, modes and layers, one thread; and the cells by one
/// thread and by all.
void measure_deterministic(const BenchmarkEffort& effort, std::uint64_t seed,
                           const ReportRow& report);

/// What the plan saves against the general one on the same stack, one thread.
void measure_plan(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// Stacks with layers of several media against stacks of each of them alone: what it costs that
/// lanes of one packet are in different media, one thread.
void measure_mixed(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// One thread against the calling thread's task arena.
void measure_threads(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// How the cost of a walk grows with layers, optical depth, cells, directions and falling
/// absorption: seconds per walk, and the exponent from one size to the next; one thread.
void measure_growth_of_walks(const BenchmarkEffort& effort, std::uint64_t seed,
                             const ReportRow& report);

/// Walks through a sparse and a dense density grid, against one majorant, a majorant per block, and
/// fixed steps; next-event estimation in the built-in stacks with grids, its shadow rays on lanes,
/// against rays in double and against counted walks: time x variance, one thread.
void measure_grids(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// Rays per second among explicit grains, nearest hit and shadow; building a scene of 10^6 spheres
/// (10^5 if quick) and the bytes it takes, its spheres included. ns_per_eval: per ray, per sphere.
/// Nothing without Embree.
void measure_grain_tracing(const BenchmarkEffort& effort, std::uint64_t seed,
                           const ReportRow& report);

/// What whole runs of this program take, from start to end: `seconds` is the median of the wall
/// clock, processor_seconds that of the processor, both over 20 runs one after the other.
void measure_startup(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

/// How far a closed form is from the truth of a stack: relative RMSE of the reflected lobe without
/// the noise, and the ends of the interval that holds it.
struct ClosedFormError {
  double error, low, high;
};

/// A closed form that claims a stack, with the parameters that it claims.
struct JudgedClosedForm {
  BoundModel bound;
  ClosedFormError error;
};

/// Every closed form that claims the stack, beside the solver where that is exact within four times
/// effort.accuracy_seconds, else beside a walk of that length.
[[nodiscard]] std::vector<JudgedClosedForm> judged_closed_forms(const Stack& stack,
                                                                const BenchmarkEffort& effort,
                                                                std::uint64_t seed);

/// Nanoseconds per evaluation of every closed form, single and in batches on the lanes of
/// effort.isa, against its textbook version where there is one, and the model's error where it
/// claims one of the stacks of the walk rows. Grey. Parameters: what the first such stack gives,
/// else the defaults.
void measure_models(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report);

}  // namespace lamella
