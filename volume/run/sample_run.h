#pragma once

#include <memory>
#include <optional>

#include "volume/grains/grain_walk.h"
#include "volume/plan/plan.h"
#include "volume/result/walk_samples.h"
#include "volume/walk/departures.h"
#include "volume/walk/incident_law.h"

namespace lamella {

class GridLaneRun;
class LaneSamples;

/// The walks of a Simulation with the same seed one by one: the light that leaves, kept instead of
/// counted. The sum of weights over the walks is the energy that the simulation finds, up to the
/// rounding of each weight to float.
///
/// Walks come in chunks, which may be taken in any order and at the same time, and are the same for
/// any number of threads. Within a chunk rows follow the numbers of the walks.
class SampleRun {
 public:
  /// Walks of light from w_i. Throws what Simulation throws.
  SampleRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed);
  /// Every walk draws its w_i over the upper hemisphere, law is not `fixed`. With density grids mu
  /// is at least kGridGrazing. Explicit geometry is refused (std::invalid_argument).
  SampleRun(const Stack& stack, const Plan& plan, IncidentLaw law, std::uint64_t seed);

  ~SampleRun();
  SampleRun(const SampleRun&) = delete;
  SampleRun& operator=(const SampleRun&) = delete;

  /// Chunks that this many walks take.
  [[nodiscard]] std::uint64_t chunks(std::uint64_t walks) const;
  /// What leaves of the walks of a chunk, as far as they are among the first `walks`. Throws
  /// NonFiniteError.
  [[nodiscard]] WalkSamples take(std::uint64_t chunk, std::uint64_t walks) const;

  /// The walks of a chunk, at most.
  [[nodiscard]] std::uint64_t chunk_walks() const { return chunk_walks_; }
  /// The instruction set of the walks.
  [[nodiscard]] Isa isa() const { return lanes_ || grid_lanes_ ? plan_.isa : Isa::scalar; }
  [[nodiscard]] const Plan& plan() const { return plan_; }

 private:
  SampleRun(const Stack& stack, const Plan& plan, Direction incident, IncidentLaw law,
            std::uint64_t seed);
  [[nodiscard]] FollowWalk follower() const;

  Stack stack_;
  Plan plan_;
  Direction incident_;
  IncidentLaw law_;
  std::uint64_t seed_, chunk_walks_;
  std::optional<GrainSetting> grains_;
  std::unique_ptr<LaneSamples> lanes_;
  std::unique_ptr<GridLaneRun> grid_lanes_;
  FollowWalk follow_;
};

}  // namespace lamella
