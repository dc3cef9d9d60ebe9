#include "volume/run/sample_run.h"

#include <algorithm>
#include <stdexcept>

#include "volume/grid_walk/grid_lane_run.h"
#include "volume/grid_walk/grid_stack.h"
#include "volume/grid_walk/grid_walk.h"
#include "volume/interfaces/boundary_run.h"
#include "volume/lanes/lane_run.h"
#include "volume/lanes/lane_samples.h"
#include "volume/run/incident_check.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

// Enough to fill the lanes beside the longest walks of a chunk, few enough for all threads to share
// a short run; and for walks that are thinned, see Simulation::stride. They divide 2^32.
constexpr std::uint64_t kChunk = 1 << 14, kThinnedChunk = 1 << 17, kScalarChunk = 1 << 11;

}  // namespace

SampleRun::SampleRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed)
    : SampleRun(stack, plan, checked_incident(stack, incident), IncidentLaw::fixed, seed) {}

SampleRun::SampleRun(const Stack& stack, const Plan& plan, IncidentLaw law, std::uint64_t seed)
    : SampleRun(stack, plan, {0, 0, 1}, law, seed) {
  if (stack.grains())
    throw std::invalid_argument(
        "explicit geometry with w_i drawn by every walk; allowed: directions");
}

SampleRun::SampleRun(const Stack& stack, const Plan& plan, Direction incident, IncidentLaw law,
                     std::uint64_t seed)
    : stack_(stack), plan_(plan), incident_(incident), law_(law), seed_(seed) {
  if (stack_.grains()) {
    grains_.emplace(stack_, incident_, seed_, plan_.max_order);
    chunk_walks_ = grains_->walks_per_realisation;
  } else if (!why_not_lanes(stack_, plan_)) {
    lanes_ = std::make_unique<LaneSamples>(stack_, plan_, incident_, law_, seed_);
    chunk_walks_ = plan_.thinning.is_on() ? kThinnedChunk : kChunk;
  } else if (plan_.has_grids()) {
    check_beside_grids("w_i", incident_);
    grid_lanes_ = GridLaneRun::make(stack_, plan_, incident_, seed_, nullptr);
    if (!grid_lanes_) follow_ = grid_follower(stack_, plan_, seed_);
    chunk_walks_ = grid_lanes_ ? kChunk : kScalarChunk;
  } else {
    follow_ = follower();
    chunk_walks_ = kScalarChunk;
  }
}

SampleRun::~SampleRun() = default;

FollowWalk SampleRun::follower() const {
  if (plan_.boundaries) return boundary_follower(stack_, plan_, seed_);
  const auto with = [this]<int C>(std::integral_constant<int, C>) -> FollowWalk {
    // The walk sees the media of this object's stack.
    return [walked = WalkStack(stack_, plan_), seed = seed_](Direction wi, std::uint64_t index,
                                                             WalkSamples& to) {
      DepartureScorer scorer(wi, to);
      BatchTally spare;
      walk<Medium, C, false>(walked, wi, seed, index, scorer, spare);
    };
  };
  return plan_.channels == 1 ? with(std::integral_constant<int, 1>())
                             : with(std::integral_constant<int, 3>());
}

std::uint64_t SampleRun::chunks(std::uint64_t walks) const {
  if (!grains_) return (walks + chunk_walks_ - 1) / chunk_walks_;
  // A chunk is a realisation, a batch of them after the other.
  const std::uint64_t round = chunk_walks_ * kBatches;
  return (walks + round - 1) / round * kBatches;
}

WalkSamples SampleRun::take(std::uint64_t chunk, std::uint64_t walks) const {
  if (grains_) {
    const int batch = static_cast<int>(chunk % kBatches);
    const std::uint64_t all = Simulation::walks_of_batch(batch, walks);
    const std::uint64_t from = std::min(chunk / kBatches * chunk_walks_, all);
    const std::uint64_t to = std::min(from + chunk_walks_, all);
    return plan_.channels == 1 ? samples_among_grains<1>(*grains_, batch, kBatches, from, to)
                               : samples_among_grains<3>(*grains_, batch, kBatches, from, to);
  }
  const std::uint64_t from = chunk * chunk_walks_, to = std::min(from + chunk_walks_, walks);
  if (lanes_) return lanes_->take(from, to);
  if (grid_lanes_) return grid_lanes_->take(law_, from, to);
  WalkSamples samples;
  samples.channels = plan_.channels;
  samples.walks = to - from;
  const double least = plan_.has_grids() ? kGridGrazing : 0;
  for (std::uint64_t k = from; k < to; ++k)
    follow_(law_ == IncidentLaw::fixed ? incident_ : drawn_incident(law_, seed_, k, least), k,
            samples);
  return samples;
}

}  // namespace lamella
