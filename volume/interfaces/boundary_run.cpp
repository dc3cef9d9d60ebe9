#include "volume/interfaces/boundary_run.h"

#include <memory>

#include "volume/interfaces/boundary_scorers.h"
#include "volume/interfaces/boundary_walk.h"

namespace lamella {
namespace {

using RunBatch = std::function<void(int, std::uint64_t, std::uint64_t)>;

template <int C, class MakeScorer>
RunBatch runner_with(std::shared_ptr<const BoundaryStack> stack, Direction incident,
                     std::uint64_t seed, std::vector<BatchTally>& batches, MakeScorer make_scorer) {
  return [=, &batches](int batch, std::uint64_t from, std::uint64_t to) {
    auto scorer = make_scorer(batch);
    for (std::uint64_t i = from; i < to; ++i) {
      const std::uint64_t index = i * kBatches + batch;
      scorer.begin_walk(seed, index);
      walk_through_boundaries<C>(*stack, incident, seed, index, scorer, batches[batch]);
    }
  };
}

template <int C>
RunBatch runner_of(const std::shared_ptr<const BoundaryStack>& stack, Direction incident,
                   std::uint64_t seed, Estimator estimator, const CellTargets& targets,
                   const std::vector<Direction>* points, std::vector<BatchTally>& batches) {
  if (points && points->empty())
    return runner_with<C>(stack, incident, seed, batches,
                          [](int) { return UnaimedAtBoundaries<NullScorer>(); });
  if (points)
    return runner_with<C>(stack, incident, seed, batches, [=, &batches](int batch) {
      return BoundaryNextEvent<C>(*stack, *points, batches[batch]);
    });
  if (estimator == Estimator::analog)
    return runner_with<C>(stack, incident, seed, batches, [&targets, &batches](int batch) {
      return UnaimedAtBoundaries<AnalogScorer<C>>(targets, batches[batch]);
    });
  return runner_with<C>(stack, incident, seed, batches, [stack, &targets, &batches](int batch) {
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

}  // namespace lamella
