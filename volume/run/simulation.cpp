#include "volume/run/simulation.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <stdexcept>

#include "volume/grid_walk/grid_walk.h"
#include "volume/interfaces/boundary_run.h"
#include "volume/lanes/lane_run.h"
#include "volume/run/incident_check.h"
#include "volume/run/point_check.h"

namespace lamella {
namespace {

/// Calls f<M, kSingle>() for the medium type and layer count that the plan asks for.
template <class F>
auto specialise(const WalkStack& stack, const Plan& plan, const F& f) {
  if (!plan.uniform_medium || stack.layers.empty())
    return f(std::type_identity<Medium>{}, std::false_type{});
  return std::visit(
      [&]<class M>(const M&) {
        return plan.single_layer ? f(std::type_identity<M>{}, std::true_type{})
                                 : f(std::type_identity<M>{}, std::false_type{});
      },
      *stack.layers[0].medium);
}

}  // namespace

Simulation::Simulation(const Stack& stack, const Plan& plan, Direction incident,
                       Estimator estimator, CellGrid grid, std::uint64_t seed)
    : stack_(stack),
      plan_(plan),
      incident_(checked_incident(stack, incident)),
      estimator_(estimator),
      seed_(seed),
      walk_stack_(stack_, plan_),
      batches_(kBatches) {
  grid.folded = plan.folded && grid.phi_cells % 2 == 0;
  targets_ = {grid, std::atan2(incident_.y, incident_.x), plan.transmits};
  has_closed_first_ = plan.order_one == OrderOne::exact && !why_no_closed_first(stack);
  for (BatchTally& batch : batches_)
    batch.f.resize(static_cast<std::size_t>(plan.order_slots()) * plan.channels * targets_.count());
  if (stack.grains()) {
    run_batch_ = grain_runner(estimator == Estimator::analog ? GrainScores::analog
                                                             : GrainScores::next_event);
    return;
  }
  if (plan.has_grids()) {
    GridRunner runner =
        grid_runner(stack_, plan_, incident_, seed, estimator, targets_, nullptr, batches_);
    run_batch_ = std::move(runner.run);
    grid_isa_ = runner.isa;
    return;
  }
  if (!(estimator == Estimator::analog ? why_not_lanes(stack_, plan_)
                                       : why_not_lanes_in_cells(stack_, plan_, targets_.grid))) {
    lanes_ =
        std::make_unique<LaneRun>(stack_, plan_, incident_, seed, kBatches, targets_, estimator);
    return;
  }
  if (plan.boundaries) {
    run_batch_ =
        boundary_runner(stack_, plan_, incident_, seed, estimator, targets_, nullptr, batches_);
    return;
  }
  run_batch_ = plan.channels == 1 ? runner<1>(estimator, false) : runner<3>(estimator, false);
}

Simulation::Simulation(const Stack& stack, const Plan& plan, Direction incident,
                       std::vector<Direction> points, std::uint64_t seed)
    : stack_(stack),
      plan_(plan),
      incident_(checked_incident(stack, incident)),
      estimator_(Estimator::next_event),
      seed_(seed),
      points_(std::move(points)),
      walk_stack_(stack_, plan_),
      batches_(kBatches) {
  for (BatchTally& batch : batches_)
    batch.f.resize(static_cast<std::size_t>(plan.order_slots()) * plan.channels * points_.size());
  if (stack.grains()) {
    run_batch_ = grain_runner(points_.empty() ? GrainScores::nothing : GrainScores::points);
    return;
  }
  if (!points_.empty()) require_aimable(stack);
  if (plan.has_grids()) {
    GridRunner runner = grid_runner(stack_, plan_, incident_, seed, Estimator::next_event, targets_,
                                    &points_, batches_);
    run_batch_ = std::move(runner.run);
    grid_isa_ = runner.isa;
    return;
  }
  if (!why_not_lanes_at(stack_, plan_, points_)) {
    lanes_ = std::make_unique<LaneRun>(stack_, plan_, incident_, seed, kBatches, points_);
    return;
  }
  if (plan.boundaries) {
    run_batch_ = boundary_runner(stack_, plan_, incident_, seed, Estimator::next_event, targets_,
                                 &points_, batches_);
    return;
  }
  run_batch_ = plan.channels == 1 ? runner<1>(Estimator::next_event, true)
                                  : runner<3>(Estimator::next_event, true);
}

Simulation::~Simulation() = default;

template <int C>
RunBatch Simulation::runner(Estimator estimator, bool points) {
  return specialise(
      walk_stack_, plan_,
      [&]<class M, bool kSingle>(std::type_identity<M>, std::bool_constant<kSingle>) {
        const auto with = [this](const auto& make_scorer) -> RunBatch {
          return batches_of_walks(seed_, batches_, make_scorer,
                                  [this](std::uint64_t index, auto& scorer, BatchTally& tally) {
                                    walk<M, C, kSingle>(walk_stack_, incident_, seed_, index,
                                                        scorer, tally);
                                  });
        };
        if (estimator == Estimator::analog)
          return with([this](int batch) { return AnalogScorer<C>(targets_, batches_[batch]); });
        if (points && points_.empty()) return with([](int) { return NullScorer(); });
        if (points)
          return with([this](int batch) {
            return NextEventScorer<C>(points_, walk_stack_, batches_[batch]);
          });
        return with([this](int batch) {
          return NextEventScorer<C>(targets_, walk_stack_, batches_[batch]);
        });
      });
}

RunBatch Simulation::grain_runner(GrainScores scores) {
  grains_.emplace(stack_, incident_, seed_, plan_.max_order);
  if (plan_.sampling == Sampling::rqmc)
    grains_->lattice = std::make_shared<const WalkLattice>(seed_);
  if (scores == GrainScores::points && grains_->geometry.surface != GrainSurface::lambert)
    throw std::invalid_argument(
        "f at points of grains that mirror; allowed: Lambertian grains, or lobes on cells (lamella "
        "simulate, compare)");
  return [this, scores](int batch, std::uint64_t from, std::uint64_t to) {
    const auto walk = plan_.channels == 1 ? walk_among_grains<1> : walk_among_grains<3>;
    walk(*grains_, scores, targets_, points_, batch, kBatches, from, to, batches_[batch]);
  };
}

std::uint64_t Simulation::walks_of_batch(int batch, std::uint64_t walks) {
  // Batch b has the walks b, b + kBatches, ...
  const auto first = static_cast<std::uint64_t>(batch);
  return walks > first ? (walks - first - 1) / kBatches + 1 : 0;
}

void Simulation::advance(std::uint64_t walks) {
  if (walks <= walks_) return;
  const int batches = range_.end - range_.first;
  if (lanes_) {
    // Thinned walks: batches are run together, in two shares per thread.
    const int shares = plan_.thinning.is_on()
                           ? std::min(batches, 2 * tbb::this_task_arena::max_concurrency())
                           : batches;
    tbb::parallel_for(0, shares, [&](int share) {
      const int first = range_.first + share * batches / shares;
      const int end = range_.first + (share + 1) * batches / shares;
      std::vector<LaneRun::Part> parts;
      for (int batch = first; batch < end; ++batch)
        parts.push_back({walks_of_batch(batch, walks_), walks_of_batch(batch, walks)});
      lanes_->run(first, parts, {batches_.data() + first, parts.size()});
    });
  } else {
    tbb::parallel_for(range_.first, range_.end, [&](int batch) {
      run_batch_(batch, walks_of_batch(batch, walks_), walks_of_batch(batch, walks));
    });
  }
  walks_ = walks;
}

std::string Simulation::lane_counts(int batch) const {
  return lanes_ ? lanes_->save(batch) : std::string();
}

void Simulation::restore(int batch, BatchTally tally, std::string_view lane_counts) {
  if (lanes_ && !lane_counts.empty()) lanes_->restore(batch, lane_counts);
  batches_[batch] = std::move(tally);
}

std::optional<LaneUse> Simulation::lane_use() const {
  if (!lanes_) return std::nullopt;
  return lanes_->use();
}

OrderOne Simulation::order_one() const {
  const std::uint64_t enough =
      estimator_ == Estimator::analog
          ? std::max(kCountedForClosedCells,
                     kCountedPerClosedCell * static_cast<std::uint64_t>(targets_.count()))
          : kNextEventForClosedCells;
  return has_closed_first_ && walks_ >= enough ? OrderOne::exact : OrderOne::walked;
}

const ClosedFirst& Simulation::closed_first() const {
  std::call_once(first_is_there_, [this] {
    first_ = lamella::closed_first(stack_, targets_.grid, incident_, plan_.channels,
                                   targets_.both_sides);
  });
  return first_;
}

std::uint64_t Simulation::collisions() const {
  std::uint64_t sum = 0;
  for (const BatchTally& batch : batches_) sum += batch.collisions;
  return sum;
}

std::uint64_t Simulation::holes() const {
  std::uint64_t sum = 0;
  for (const BatchTally& batch : batches_) sum += batch.holes;
  return sum;
}

std::uint64_t Simulation::stride() const {
  // The longest of thinned walks on lanes take their time after all others have ended.
  if (lanes_ && plan_.thinning.is_on() && estimator_ == Estimator::analog) return 1 << 17;
  return kBatches * (grains_ ? grains_->walks_per_realisation : 1);
}

double run(Simulation& simulation, const StopRule& rule,
           const std::function<void(const Progress&)>& progress,
           const std::atomic<bool>* interrupted) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  constexpr double kCheckpointSeconds = 0.2;
  std::uint64_t chunk = std::max<std::uint64_t>(16 * kBatches, simulation.stride());
  // Where the clock decides a first step must be short: one walk per batch, or a realisation.
  if (rule.seconds) chunk = simulation.lane_use() ? kBatches : simulation.stride();
  std::uint64_t next_test = std::max<std::uint64_t>(1 << 14, simulation.stride());
  // Walks that were restored may stand at a test, or between two.
  while (next_test < simulation.walks()) next_test *= 2;
  const auto is_reached = [&] {
    if (!rule.target_error || simulation.walks() < next_test) return false;
    next_test *= 2;
    return largest_relative_error(simulation) <= *rule.target_error;
  };
  while (simulation.walks() < rule.walks && !is_reached()) {
    std::uint64_t goal = std::min(rule.walks, simulation.walks() + chunk);
    if (rule.target_error) goal = std::min(goal, std::max(next_test, simulation.walks() + 1));
    const double before = elapsed();
    simulation.advance(goal);
    const double now = elapsed();
    if (now - before < kCheckpointSeconds) chunk *= 2;
    if (progress) progress({simulation.walks(), rule.walks, now});
    if (interrupted && *interrupted) break;
    if (rule.seconds && now >= *rule.seconds) break;
  }
  return elapsed();
}

}  // namespace lamella
