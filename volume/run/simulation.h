#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volume/grains/grain_walk.h"
#include "volume/plan/plan.h"
#include "volume/result/run_result.h"
#include "volume/result/tally.h"
#include "volume/solver/closed_first.h"
#include "volume/walk/scorers.h"
#include "volume/walk/walk_batches.h"

namespace lamella {

class LaneRun;

/// The batches first, first + 1, ... end - 1.
struct BatchRange {
  int first = 0, end = kBatches;
};

/// The walks of one incident direction, through layers or among explicit grains. For a given seed,
/// estimator and number of walks the sums are the same to the last bit for any number of threads
/// and any sequence of calls of `advance`.
class Simulation {
 public:
  /// Lobes on cells. `incident`: unit, mu = 0 is the limit from above; below a half space or an
  /// opaque substrate it is refused (std::invalid_argument), as is, on explicit geometry, |mu|
  /// below kGrainGrazingLimit. Explicit geometry without Embree throws GeometryError.
  Simulation(const Stack& stack, const Plan& plan, Direction incident, Estimator estimator,
             CellGrid grid, std::uint64_t seed);
  /// f at points, by next-event estimation. Every point must have mu != 0; those that go up first.
  /// Without points: the energies alone. Mirror grains cannot be aimed at points: refused.
  Simulation(const Stack& stack, const Plan& plan, Direction incident,
             std::vector<Direction> points, std::uint64_t seed);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Continues to `walks` in all, in the calling thread's task arena. Throws NonFiniteError.
  void advance(std::uint64_t walks);

  /// From here on only these batches walk, as they would beside all others: a part of a run that
  /// is divided among processes. `walks` and `stride` still mean those of all batches.
  void walk_only(BatchRange range) { range_ = range; }
  [[nodiscard]] BatchRange range() const { return range_; }

  [[nodiscard]] std::uint64_t walks() const { return walks_; }
  [[nodiscard]] std::uint64_t collisions() const;
  /// Rays that a defect of explicit geometry let into a grain: 0.
  [[nodiscard]] std::uint64_t holes() const;
  /// Advancing by a multiple of this many walks wastes nothing: among grains, whole realisations;
  /// where walks are thinned, enough walks to fill the lanes beside the longest ones.
  [[nodiscard]] std::uint64_t stride() const;
  [[nodiscard]] const std::vector<BatchTally>& batches() const { return batches_; }
  [[nodiscard]] const CellTargets& targets() const { return targets_; }
  [[nodiscard]] Direction incident() const { return incident_; }
  [[nodiscard]] const Stack& stack() const { return stack_; }
  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] Estimator estimator() const { return estimator_; }
  /// The instruction set of the walks: the plan's, or scalar where that set has no kernel for them.
  [[nodiscard]] Isa isa() const { return lanes_ ? plan_.isa : grid_isa_; }
  /// Where the numbers of the walks' first steps come from.
  [[nodiscard]] Sampling sampling() const {
    const bool has_lattices = lanes_ || plan_.has_grids() || grains_;
    return has_lattices ? plan_.sampling : Sampling::random;
  }
  /// Nothing for scalar walks.
  [[nodiscard]] std::optional<LaneUse> lane_use() const;

  /// Where a result takes order 1 from: the closed form, if the plan asks for it, the stack has one
  /// (why_no_closed_first) and the walks so far take longer than it does. Walks count order 1 in
  /// any case, so tallies, parts and checkpoints are the same.
  [[nodiscard]] OrderOne order_one() const;
  /// The slot of the first order that a result has from walks.
  [[nodiscard]] int first_walked() const { return order_one() == OrderOne::exact ? 1 : 0; }
  /// Order 1 on the cells, computed by the first call.
  [[nodiscard]] const ClosedFirst& closed_first() const;

  /// How many of the first `walks` walks are a batch's.
  [[nodiscard]] static std::uint64_t walks_of_batch(int batch, std::uint64_t walks);
  /// What walks on lanes need beside a batch's tally to go on; nothing for others.
  [[nodiscard]] std::string lane_counts(int batch) const;
  /// Puts a tally in the place of a batch's, and what `lane_counts` gave with it; without that it
  /// can be reduced, but not go on. Throws DamagedBytes where the counts are none of this batch's.
  void restore(int batch, BatchTally tally, std::string_view lane_counts);
  /// How many walks there are once batches were restored.
  void restore_walks(std::uint64_t walks) { walks_ = walks; }

 private:
  template <int C>
  [[nodiscard]] RunBatch runner(Estimator estimator, bool points);
  [[nodiscard]] RunBatch grain_runner(GrainScores scores);

  Stack stack_;
  Plan plan_;
  Direction incident_;
  Estimator estimator_;
  std::uint64_t seed_;
  std::uint64_t walks_ = 0;
  BatchRange range_;
  Isa grid_isa_ = Isa::scalar;
  CellTargets targets_;
  std::vector<Direction> points_;
  WalkStack walk_stack_;
  std::optional<GrainSetting> grains_;
  std::vector<BatchTally> batches_;
  RunBatch run_batch_;
  std::unique_ptr<LaneRun> lanes_;
  bool has_closed_first_ = false;
  mutable std::once_flag first_is_there_;
  mutable ClosedFirst first_;
};

/// Walks from which on a result takes order 1 in closed form: counted walks per target (a cell on
/// one side) and in all, and next-event walks, which take longer the more targets there are.
inline constexpr std::uint64_t kCountedPerClosedCell = 1024, kCountedForClosedCells = 16384,
                               kNextEventForClosedCells = 4096;

/// Reduces the batches of a simulation on cells, in batch order.
[[nodiscard]] RunResult reduce(const Simulation& simulation);

/// The index of side and cell among the targets of a tally.
[[nodiscard]] inline int target_of(const CellTargets& targets, bool up, int cell) {
  return cell + (up ? 0 : targets.grid.cells());
}

/// When to stop. Walks are always bounded; the others end a run earlier.
struct StopRule {
  std::uint64_t walks = 1000000;
  std::optional<double> target_error;  ///< largest relative standard error of lobe energies > 1e-3
  std::optional<double> seconds;
};

/// The state of a run at a checkpoint.
struct Progress {
  std::uint64_t walks, of_walks;
  double seconds;
};

/// Advances until the rule says stop. The error is tested at doubling numbers of walks only, from
/// 2^14 on, because stopping on an error is biased. Returns the seconds taken. `interrupted` ends
/// the run at the next checkpoint. Walks that were restored go on as if nothing had ended them.
double run(Simulation& simulation, const StopRule& rule,
           const std::function<void(const Progress&)>& progress,
           const std::atomic<bool>* interrupted);

/// The largest relative standard error over the lobe energies above 1e-3.
[[nodiscard]] double largest_relative_error(const Simulation& simulation);

}  // namespace lamella
