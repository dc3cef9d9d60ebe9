#pragma once

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "phase/random/random.h"
#include "phase/stack/stack.h"
#include "volume/plan/plan.h"
#include "volume/result/tally.h"
#include "volume/walk/path_weight.h"

namespace lamella {

/// A number that is not finite came up in a walk: a defect. what() says how to replay it.
struct NonFiniteError : std::runtime_error {
  NonFiniteError(std::uint64_t seed, std::uint64_t walk, Direction wi);
};

/// A layer as the walk sees it. Depth is thickness times density, the only length there is.
struct WalkLayer {
  const Medium* medium;
  double depth;
  std::array<double, 3> albedo, f0;
  bool fresnel;
};

/// A stack as the walk sees it: layers that have depth, from the top.
struct WalkStack {
  WalkStack(const Stack& stack, const Plan& plan);

  std::vector<WalkLayer> layers;
  bool has_substrate;
  std::array<double, 3> substrate_albedo;
  std::uint64_t max_order;
  Thinning thinning;
};

namespace walk_detail {

template <class F>
decltype(auto) with_medium(const Medium& medium, F&& f) {
  return std::visit(f, medium);
}
template <class M, class F>
decltype(auto) with_medium(const M& medium, F&& f) {
  return f(medium);
}

/// The medium of a layer: as the alternative M where all layers hold it, else as the variant.
template <class M>
[[nodiscard]] inline const M& medium_of(const WalkLayer& layer) {
  if constexpr (std::is_same_v<M, Medium>)
    return *layer.medium;
  else
    return *std::get_if<M>(layer.medium);
}

}  // namespace walk_detail

/// Tells a scorer that asks for it what leaves the stack, deltas too.
template <class Scorer, std::size_t C>
void tell_departure(Scorer& scorer, Direction wo, const std::array<double, C>& weight,
                    std::uint64_t order, bool delta) {
  if constexpr (requires { scorer.departs(wo, weight, order, delta); })
    scorer.departs(wo, weight, order, delta);
}

/// Follows one walk of light from w_i through the stack and reports its events to `tally` and
/// `scorer`. M: the medium of every layer, or Medium; C: channels; kSingle: one layer.
///
/// Position-free: a layer index and the depth y below that layer's top. A walk carries weights of
/// at most 1 (volume/walk/path_weight.h), doubled whenever thinning spared it.
template <class M, int C, bool kSingle, class Scorer>
void walk(const WalkStack& stack, Direction incident, std::uint64_t seed, std::uint64_t index,
          Scorer& scorer, BatchTally& tally) {
  using walk_detail::medium_of;
  using walk_detail::with_medium;
  RandomStream stream(seed, index, StreamPurpose::walk);
  EnergySums& energy = tally.energy;
  const int last = static_cast<int>(stack.layers.size()) - 1;
  Direction wi = incident;  // points back to where the light comes from
  PathWeight<C> weight;
  int layer = wi.z > 0 ? 0 : last;
  double y = wi.z > 0 || last < 0 ? 0 : stack.layers[layer].depth;
  std::uint64_t order = 0;
  bool only_delta = true, last_delta = false;

  for (;;) {
    // Free flight along -wi, exact across layers.
    double remaining = stream.exponential();
    const bool down = wi.z > 0;
    bool collides = false;
    while (kSingle || (layer >= 0 && layer <= last)) {
      const WalkLayer& l = stack.layers[kSingle ? 0 : layer];
      const double area =
          with_medium(medium_of<M>(l), [&](const auto& medium) { return medium.sigma(wi); });
      // Where the light would collide; it does if that is short of the boundary ahead. A
      // direction's sign is random: no branch on it. Not a number or infinite where no area faces
      // the light.
      const double to = y + remaining * wi.z / area;
      if (((to > 0) | down) & ((to < l.depth) | !down)) {
        y = to;
        collides = true;
        break;
      }
      if constexpr (kSingle) break;
      if (area > 0) remaining -= area * (down ? l.depth - y : y) / std::max(std::abs(wi.z), 1e-300);
      layer += down ? 1 : -1;
      if (layer >= 0 && layer <= last) y = down ? 0 : stack.layers[layer].depth;
    }

    if (!collides && !(down && stack.has_substrate)) {  // leaves the stack
      weight.leave(energy, down, order, only_delta);
      tell_departure(scorer, -wi, weight.value, order, only_delta);
      if (!only_delta) scorer.leave(-wi, weight.value, order, last_delta);
      break;
    }
    if (order == stack.max_order) {
      weight.add_to(energy.unresolved);
      break;
    }
    ++order;

    if (!collides) {  // the substrate reflects by Lambert's law
      only_delta = last_delta = false;
      std::array<double, C> kept;
      for (int c = 0; c < C; ++c) kept[c] = stack.substrate_albedo[c];
      scorer.substrate(weight.value, kept, order);
      if (!weight.survives(kept, order, energy, stream)) break;
      if (stack.thinning.halves_at(order) && !weight.is_spared(energy, stream)) break;
      wi = -kLambertSubstrate.sample(stream).wo;
      layer = last;
      if (last >= 0) y = stack.layers[last].depth;
      continue;
    }

    ++tally.collisions;
    const WalkLayer& l = stack.layers[kSingle ? 0 : layer];
    const bool alive = with_medium(medium_of<M>(l), [&](const auto& medium) {
      const auto event = medium.collide(wi, stream);
      last_delta = medium.is_delta();
      if (!last_delta) {
        only_delta = false;
        scorer.collision(l, kSingle ? 0 : layer, y, event, weight.value, order);
      }
      const Scatter scatter = event.sample(stream);
      const auto kept = kept_shares<C>(l.albedo, l, scatter.schlick);
      if (!weight.survives(kept, order, energy, stream)) return false;
      wi = -scatter.wo;
      return true;
    });
    if (!alive) break;
    if (stack.thinning.halves_at(order) && !weight.is_spared(energy, stream)) break;
  }
  ++tally.walks;
  double check = wi.x + wi.y + wi.z + y;
  for (int c = 0; c < C; ++c) check += weight.value[c];
  if (!std::isfinite(check) || !scorer.finite()) throw NonFiniteError(seed, index, incident);
}

}  // namespace lamella
