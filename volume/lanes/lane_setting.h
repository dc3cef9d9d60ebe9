#pragma once

#include <optional>
#include <vector>

#include "phase/interface/dielectric.h"
#include "volume/interfaces/boundary_stack.h"
#include "volume/lanes/lane_boundaries.h"
#include "volume/lanes/lane_step.h"
#include "volume/plan/plan.h"

namespace lamella {

/// A part of a layer that lanes take as a layer of its own.
struct LanePart {
  int layer;  ///< of the stack; -1: an empty one between interfaces
  double depth;
  std::optional<Dielectric> above{};  ///< the interface on top of it, if there is one
};

/// The layers of a plan as lanes take them. Depth is kept from a layer's top, and float would not
/// resolve where light enters a deep slab from below: layers deeper than kDeepestPart are cut into
/// a bulk, in whose midst a place may be rounded, and two ends.
[[nodiscard]] std::vector<LanePart> lane_parts(const Stack& stack, const Plan& plan);
/// The interface below the last part, if there is one.
[[nodiscard]] std::optional<Dielectric> lane_bottom(const Stack& stack, const Plan& plan);
inline constexpr double kDeepestPart = 16;

/// Whether walks that are counted or kept where they leave, and send no light anywhere, take the
/// normals of the stack's flakes by null collisions (volume/lanes/lane_null_flakes.h): in one layer
/// of vMF flakes about z, none too narrow, or so deep and face down that light meets hardly
/// anything else.
[[nodiscard]] bool takes_null_collisions(const Stack& stack, const Plan& plan);

/// Whether all lanes walk in one layer at a time (volume/lanes/lane_layer_loop.h) rather than each
/// in its own: where that is faster, since walks stay in a layer long enough to pay for their way
/// into it, or since masks would cost more. `lamella bench --only mixed` measures both.
template <class Scalar>
[[nodiscard]] bool walks_by_layer(const WalkSetting<Scalar>& walk);

/// A stack and its light in the numbers of lanes (float), or of their reference (double). The
/// tables must outlive what points to them.
template <class Scalar>
struct LaneSetting {
  /// counted: of walks that are counted where they leave, see takes_null_collisions.
  LaneSetting(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
              bool counted = false);
  LaneSetting(const LaneSetting&) = delete;
  LaneSetting& operator=(const LaneSetting&) = delete;

  /// Without weights: what a walk weighs after `order` events. From the fourth event on it survives
  /// with the chance of the brightest channel.
  [[nodiscard]] double weight_after(int channel, std::uint32_t order) const;

  LayerNumbers<Scalar> layers;
  BoundaryNumbers<Scalar> boundaries;  ///< of stacks with interfaces
  WalkSetting<Scalar> walk;
  std::vector<LanePart> parts;
  std::vector<NormalPatch> tables;
  /// Of every layer, or of the substrate alone, where all are the same: walks then carry no
  /// weights, the order tells them.
  bool common_albedo = false;
  std::array<double, 3> albedo{};
  double collides = 1;  ///< the chance of a first collision, where there are no boundaries
  double chance = 1;    ///< the same where it is forced, else 1

  /// Forces the first kForcedFlights flights: of walks without weights over no substrate, each in
  /// its own layer.
  void force_flights();
};

}  // namespace lamella
