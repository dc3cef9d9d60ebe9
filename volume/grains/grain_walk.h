#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/grains/grain_scene.h"
#include "volume/walk/scorers.h"
#include "volume/walk/walk_lattice.h"

namespace lamella {

struct WalkSamples;

/// The counts of walks among grains, beside the energies.
enum class GrainScores {
  nothing,
  analog,      ///< light that leaves, in cells
  next_event,  ///< every event's light, in cells: one direction in each, redrawn for every walk
  points       ///< every event's light, at given directions
};

/// The data that all walks of a simulation among grains share.
struct GrainSetting {
  GrainSetting(const Stack& stack, Direction incident, std::uint64_t seed, std::uint64_t max_order);

  GrainGeometry geometry;  ///< in_units: walks do not depend on the scale
  Rgb albedo, f0;
  bool has_substrate;
  Rgb substrate_albedo;
  std::shared_ptr<const SurfaceLaw> substrate_law;  ///< where it is not Lambert's
  Direction incident;
  std::uint64_t seed, max_order;
  /// Of a dielectric grain: Lambertian reflectance of the light that enters, so that an albedo of 1
  /// loses nothing; and 1 minus the mean Fresnel reflectance.
  Rgb inner{0};
  double entering = 1;
  /// Walks that share one realisation of the grains; together they cost about as much time as
  /// building the realisation.
  std::uint64_t walks_per_realisation;
  /// Of the walks' first numbers; nothing: all of them are random.
  std::shared_ptr<const WalkLattice> lattice{};
};

/// Least |mu| of light that is sent among grains: below, a period would be crossed too often.
inline constexpr double kGrainGrazingLimit = 1e-3;

/// Walks `from` to `to` of a batch. Walk i of batch b stands in the realisation number i /
/// walks_per_realisation of that batch, turned about z by a random angle, so that the ensemble is
/// symmetric about z; its numbers come from (seed, i * batches + b) as in any simulation.
/// `targets`: the cells; `points`: the directions of GrainScores::points. C: channels.
///
/// Orders, weights and the ledger are those of `walk`: the light enters over the whole tile at the
/// top, every grain or substrate that is met is an event, light that leaves below a bed without
/// substrate is transmitted. Rays that are lost (RayEnd::lost) count as unresolved.
template <int C>
void walk_among_grains(const GrainSetting& setting, GrainScores scores, const CellTargets& targets,
                       const std::vector<Direction>& points, int batch, int batches,
                       std::uint64_t from, std::uint64_t to, BatchTally& tally);

/// The same walks one by one: what leaves.
template <int C>
[[nodiscard]] WalkSamples samples_among_grains(const GrainSetting& setting, int batch, int batches,
                                               std::uint64_t from, std::uint64_t to);

}  // namespace lamella
