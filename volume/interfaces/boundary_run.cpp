#include "volume/interfaces/boundary_run.h"

#include <memory>

#include "volume/interfaces/boundary_scorers.h"
#include "volume/interfaces/boundary_walk.h"

namespace lamella {
namespace {

template <int C>
RunBatch runner_of(const std::shared_ptr<const BoundaryStack>& stack, Direction incident,
                   std::uint64_t seed, Estimator estimator, const CellTargets& targets,
                   const std::vector<Direction>* points, std::vector<BatchTally>& batches) {
  const auto with = [&](const auto& make_scorer) {
    return batches_of_walks(
        seed, batches, make_scorer, [=](std::uint64_t index, auto& scorer, BatchTally& tally) {
          walk_through_boundaries<C>(*stack, incident, seed, index, scorer, tally);
        });
  };
  if (points && points->empty()) return with([](int) { return UnaimedAtBoundaries<NullScorer>(); });
  if (points)
    return with(
        [=, &batches](int batch) { return BoundaryNextEvent<C>(*stack, *points, batches[batch]); });
  if (estimator == Estimator::analog)
    return with([&targets, &batches](int batch) {
      return UnaimedAtBoundaries<AnalogScorer<C>>(targets, batches[batch]);
    });
  return with([stack, &targets, &batches](int batch) {
    return BoundaryNextEvent<C>(*stack, targets, batches[batch]);
  });
}

}  // namespace

RunBatch boundary_runner(const Stack& stack, const Plan& plan, Direction incident,
                         std::uint64_t seed, Estimator estimator, const CellTargets& targets,
                         const std::vector<Direction>* points, std::vector<BatchTally>& batches) {
  const auto shared = std::make_shared<const BoundaryStack>(stack, plan);
  return plan.channels == 1
             ? runner_of<1>(shared, incident, seed, estimator, targets, points, batches)
             : runner_of<3>(shared, incident, seed, estimator, targets, points, batches);
}

FollowWalk boundary_follower(const Stack& stack, const Plan& plan, std::uint64_t seed) {
  const auto shared = std::make_shared<const BoundaryStack>(stack, plan);
  const auto with = [&]<int C>(std::integral_constant<int, C>) -> FollowWalk {
    return [shared, seed](Direction wi, std::uint64_t index, WalkSamples& to) {
      UnaimedAtBoundaries<DepartureScorer> scorer(wi, to);
      BatchTally spare;
      walk_through_boundaries<C>(*shared, wi, seed, index, scorer, spare);
    };
  };
  return plan.channels == 1 ? with(std::integral_constant<int, 1>())
                            : with(std::integral_constant<int, 3>());
}

}  // namespace lamella
