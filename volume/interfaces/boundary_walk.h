#pragma once

#include "volume/interfaces/boundary_stack.h"
#include "volume/walk/path_weight.h"
#include "volume/walk/walk.h"

namespace lamella {

/// Boundaries that light may meet between two events before the walk is cut as unresolved: only
/// light that is reflected for ever reaches it.
inline constexpr int kMostBoundaries = 1 << 20;

namespace boundary_detail {

// What a walk has met so far.
struct Met {
  bool only_delta = true;  // smooth boundaries, delta flakes, smooth conductors
  /// Nothing has been scored since the last event that cannot be aimed: what leaves now counts in
  /// its cell, if anything does.
  bool open = true;
};

/// Books what leaves the stack: order 0 of light that met interfaces alone, or as uncollided if it
/// has gone straight through smooth ones.
template <int C>
void leave(const PathWeight<C>& weight, EnergySums& energy, bool down, bool passes,
           std::uint64_t order, bool only_delta) {
  if (order > 0) {
    weight.leave(energy, down, order, only_delta);
  } else if (only_delta && passes) {
    weight.add_to(energy.uncollided);
  } else {
    weight.add_to(down ? energy.zero_down : energy.zero_up);
    if (only_delta) weight.add_to(down ? energy.specular_down : energy.specular_up);
  }
}

/// Tells a scorer that asks for it along which direction the event goes on that it has just scored:
/// density() is that direction's [1/sr], given what the event had drawn.
template <class Scorer, class Density>
void tell_course(Scorer& scorer, const Density& density) {
  if constexpr (requires { scorer.goes_on(0.0); }) scorer.goes_on(density());
}

}  // namespace boundary_detail

/// Follows one walk of light from w_i through a stack with interfaces, like walk() in walk.h:
/// position-free, weights of at most 1 but for closed forms as substrates. At a boundary Fresnel's
/// shares decide by chance; light in the shadow of single scattering is `lost`.
/// Scorer: collision() and substrate() as events that can be aimed; sees_mirrors(), whether these
/// count what a mirror as substrate makes of the light; interface(), for a rough
/// boundary that light meets when nothing has been scored yet, answers whether it scored;
/// leave(w_o, weight, order, open); goes_on(density), if there is such, after each event that was
/// scored, with the density of the direction that the walk takes there.
template <int C, class Scorer>
void walk_through_boundaries(const BoundaryStack& stack, Direction incident, std::uint64_t seed,
                             std::uint64_t index, Scorer& scorer, BatchTally& tally) {
  RandomStream stream(seed, index, StreamPurpose::walk);
  EnergySums& energy = tally.energy;
  const int n = stack.count();
  Direction wi = incident;  // points back to where the light comes from
  PathWeight<C> weight;
  boundary_detail::Met met;
  std::uint64_t order = 0;
  int boundary = wi.z > 0 ? 0 : n, boundaries = 0;

  for (;;) {
    // At a boundary, from above where wi.z > 0.
    if (boundary == n && stack.has_substrate && wi.z > 0) {
      if (order == stack.max_order) {
        weight.add_to(energy.unresolved);
        break;
      }
      ++order;
      boundaries = 0;
      std::array<double, C> kept, lost{};
      Direction wo;
      if (stack.law) {
        if (!stack.law->is_delta()) {
          met = {false, false};
          scorer.substrate(weight.value, *stack.law, wi, order, stream);
        } else if (!scorer.sees_mirrors()) {
          met.open = true;
        }
        const auto sample = stack.law->sample(wi, stream);
        for (int c = 0; c < C; ++c) {
          kept[c] = sample ? sample->weight[c] : 0;
          lost[c] = sample ? sample->lost[c] : 0;
        }
        wo = sample ? sample->wo : wi;
        if (!stack.law->is_delta())
          boundary_detail::tell_course(scorer, [&] { return stack.law->density(wi, wo); });
      } else {
        met = {false, false};
        for (int c = 0; c < C; ++c) kept[c] = stack.substrate_albedo[c];
        scorer.substrate(weight.value, kept, order);
        wo = kLambertSubstrate.sample(stream).wo;
        boundary_detail::tell_course(scorer, [&] {
          return kLambertSubstrate.density({0, 0, wo.z}).density;
        });
      }
      for (int c = 0; c < C; ++c) {
        energy.lost[c] += lost[c] * weight.value[c];
        energy.absorbed[c] -= lost[c] * weight.value[c];
      }
      if (!weight.survives(kept, order, energy, stream)) break;
      if (stack.thinning.halves_at(order) && !weight.is_spared(energy, stream)) break;
      wi = -wo;
    } else if (const auto& interface = stack.boundaries[boundary]) {
      bool scored = false;
      if (!interface->is_smooth()) {
        scored =
            met.open && scorer.interface(boundary, *interface, wi, weight.value, order, stream);
        if (scored) met.open = false;
        met.only_delta = false;
      }
      const Dielectric::Scattered scattered = interface->scatter(wi, stream);
      if (scored)
        boundary_detail::tell_course(scorer,
                                     [&] { return interface->single_density(wi, scattered.wo); });
      if (scattered.kept < 1 && stream.uniform() >= scattered.kept) {
        weight.add_to(energy.lost);
        break;
      }
      wi = -scattered.wo;
      if (++boundaries == kMostBoundaries) {
        weight.add_to(energy.unresolved);
        break;
      }
    }
    const int layer = wi.z > 0 ? boundary : boundary - 1;
    if (layer < 0 || layer >= n) {
      const bool down = wi.z > 0;
      boundary_detail::leave(weight, energy, down, down == (incident.z > 0), order, met.only_delta);
      tell_departure(scorer, -wi, weight.value, order, met.only_delta);
      if (!met.only_delta) scorer.leave(-wi, weight.value, order, met.open);
      break;
    }

    // Flights and events in the layer, until a boundary is reached.
    const WalkLayer& l = stack.layers[layer];
    double y = wi.z > 0 ? 0 : l.depth;
    bool alive = true;
    for (;;) {
      const bool down = wi.z > 0;
      if (l.depth == 0) {
        boundary = down ? layer + 1 : layer;
        break;
      }
      const double area = sigma(*l.medium, wi);
      double remaining = stream.exponential();
      if (boundaries > 0 && stack.is_trapped(layer, wi)) {
        // Whole ways there and back change nothing.
        const double back = sigma(*l.medium, {wi.x, wi.y, -wi.z});
        remaining = std::fmod(remaining, (area + back) * l.depth / std::abs(wi.z));
      }
      const double to = y + remaining * wi.z / area;
      if (!(((to > 0) | down) & ((to < l.depth) | !down))) {
        boundary = down ? layer + 1 : layer;
        break;
      }
      y = to;
      if (order == stack.max_order) {
        weight.add_to(energy.unresolved);
        alive = false;
        break;
      }
      ++order;
      boundaries = 0;
      ++tally.collisions;
      alive = std::visit(
          [&](const auto& medium) {
            const auto event = medium.collide(wi, stream);
            if (medium.is_delta()) {
              met.open = true;
            } else {
              met = {false, false};
              scorer.collision(l, layer, y, event, weight.value, order);
            }
            const Scatter scatter = event.sample(stream);
            if (!medium.is_delta())
              boundary_detail::tell_course(scorer,
                                           [&] { return event.density(scatter.wo).density; });
            const auto kept = kept_shares<C>(l.albedo, l, scatter.schlick);
            if (!weight.survives(kept, order, energy, stream)) return false;
            wi = -scatter.wo;
            return true;
          },
          *l.medium);
      if (alive && stack.thinning.halves_at(order)) alive = weight.is_spared(energy, stream);
      if (!alive) break;
    }
    if (!alive) break;
  }
  ++tally.walks;
  double check = wi.x + wi.y + wi.z;
  for (int c = 0; c < C; ++c) check += weight.value[c];
  if (!std::isfinite(check) || !scorer.finite()) throw NonFiniteError(seed, index, incident);
}

}  // namespace lamella
