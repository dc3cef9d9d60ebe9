#pragma once

// What walks on lanes are: the stack and its light as they know them, where a walk is, and how it
// ends. Templates over the number type: lanes of float, and the double that they are held against.

#include "phase/random/lattice.h"
#include "volume/lanes/lane_media.h"

namespace lamella {

/// Random streams of a walk on lanes, beside those of StreamPurpose: one gives the state that its
/// generator begins from, one the place within cells that an event's light is sent to.
inline constexpr std::uint32_t kLaneWalkStream = 4, kLaneTargetStream = 6;

/// What became of a walk.
enum class WalkEnd : std::uint32_t { up = 0, down = 1, absorbed = 2, unresolved = 3, thinned = 4 };
inline constexpr int kWalkEnds = 5;
/// Walks through boundaries have three rows more (volume/lanes/lane_boundaries.h).
template <bool kBounded>
inline constexpr int kEndRows = kBounded ? kWalkEnds + 3 : kWalkEnds;
inline constexpr int kLostRow = kWalkEnds;       ///< in the shadow of facets
inline constexpr int kDeltaRow = kWalkEnds + 1;  ///< left up, and down, by smooth boundaries alone
/// The row of light that goes straight through.
template <bool kBounded>
[[nodiscard]] LAMELLA_INLINE constexpr int straight_row(bool from_above) {
  return (kBounded ? kDeltaRow : 0) + (from_above ? 1 : 0);
}
/// Bits of a walk's end beside its order, through boundaries.
inline constexpr int kBoundedBits = 5;
inline constexpr std::uint32_t kLostBit = 4, kMetDeltasBit = 8, kCutBit = 16;
/// The highest order that leaves room for them.
inline constexpr std::uint64_t kMostBoundedOrder = 100000000;
/// Flights that are forced where any are but the first: those that take numbers of a lattice.
inline constexpr std::uint32_t kForcedFlights = kLatticeSteps;
/// The order from which on walks end by roulette: kTallyOrders.
inline constexpr std::uint32_t kRouletteOrder = 4;

template <class Scalar>
struct BoundaryNumbers;

/// A stack and its light as walks on lanes know them.
template <class Scalar>
struct WalkSetting {
  const LayerNumbers<Scalar>* layers = nullptr;
  int layer_count = 0;
  unsigned kinds = 0;  ///< bit LaneMediumKind: there is a layer of it, or a substrate
  bool substrate = false, fresnel = false, from_above = true;
  bool grey = true;      ///< all channels are the same
  bool upright = false;  ///< all matrices are UprightSggxMatrix's
  bool narrow = false;   ///< there are vMF flakes of NarrowVmfOnLanes
  Scalar wi[3] = {};
  bool collides_at_once = false;  ///< as good as every walk meets something
  /// Above 0: every walk collides; this is the chance that it would, and that it would not.
  Scalar forced_chance = 0, forced_rest = 0;
  /// Next event: how many of a walk's flights are forced, the first among them, see
  /// volume/lanes/lane_forced_flights.h.
  std::uint32_t forced_flights = 0;
  /// Walks without weights: 1 / -log(albedo), infinity at albedo 1. From the fourth event on a walk
  /// survives with the albedo.
  Scalar orders_per_absorption = 0;
  bool black = false;  ///< the first event ends a walk
  /// Walks without weights: what an event ends is absorbed, at the fourth event or later.
  bool ends_absorb = false;
  bool by_layer = false;         ///< all lanes walk in one layer at a time, see walks_by_layer
  bool null_collisions = false;  ///< the medium is one of volume/lanes/lane_null_flakes.h
  Scalar substrate_albedo[3] = {};
  std::uint32_t max_order = 0;
  std::uint32_t thinned_from = 0;  ///< Thinning::first
  int words = 1;  ///< random words that an event takes: the most that any of the media needs
  std::uint64_t seed = 0;
  const LatticeNumbers* lattice = nullptr;  ///< of the first steps; none: all words are random
  const BoundaryNumbers<Scalar>* boundaries = nullptr;  ///< of stacks with interfaces
};

/// Walks, one per lane. C: weights that they carry, 3, or 0 where the order alone tells them.
template <class Real, int C>
struct LaneState {
  Vec3<Real> wi;  ///< points back to where the light comes from
  Real y;         ///< depth below the layer's top
  WordsOf<Real> layer, order, index;
  /// The event that ends the walk, as one too many or by thinning; without weights by roulette,
  /// too.
  WordsOf<Real> death;
  WalkNumbers<WordsOf<Real>> numbers;
  /// With a lattice: the walk's point, its batch's shift where walks of several batches share the
  /// lanes, and the steps that it has taken, where they are not its order.
  WordsOf<Real> point, shift, step;
  /// Without weights: the share of the walk that goes on, where flights are forced.
  Real weight[C > 0 ? C : 1];
};

}  // namespace lamella
