#include "volume/grid_walk/grid_walk.h"

#include <algorithm>

#include "volume/grid_walk/grid_lane_run.h"
#include "volume/grid_walk/grid_march.h"
#include "volume/grid_walk/grid_scorers.h"
#include "volume/walk/path_weight.h"
#include "volume/walk/walk.h"

namespace lamella {

namespace {

// `walk` with a place in the tile: the same ledger, the same chance of survival. The numbers of the
// first steps are the point's, where it has any.
template <int C, class Scorer>
void walk_in_grids(const GridWalkStack& stack, Direction incident, std::uint64_t seed,
                   std::uint64_t index, WalkLattice::Point lattice, Scorer& scorer,
                   BatchTally& tally) {
  RandomStream stream(seed, index, StreamPurpose::walk);
  lattice.put(0, kEventWord, stream);
  EnergySums& energy = tally.energy;
  const int last = static_cast<int>(stack.layers.size()) - 1;
  Direction wi = incident;  // points back to where the light comes from
  PathWeight<C> weight;
  Place at{wi.z > 0 ? 0 : last, stack.tile_x * stream.uniform(), stack.tile_y * stream.uniform(),
           0};
  if (wi.z < 0) at.z = stack.layers[last].thickness;
  std::uint64_t order = 0;
  bool only_delta = true, last_delta = false;

  for (;;) {
    if (lattice.has(order))
      stream.put(lattice.word(order, kFlightWord), lattice.word(order, kAcceptanceWord));
    double remaining = stream.exponential();
    const bool down = wi.z > 0;
    bool endless = false;
    GridFlight flight;
    while (at.layer >= 0 && at.layer <= last) {
      const GridWalkLayer& l = stack.layers[at.layer];
      flight.end = Flight::left;
      if (l.grid) {
        flight = std::visit(
            [&]<class M>(const M&) {
              if (Scorer::kFirstFlightByVoxels && order == 0 && lattice.has(0))
                return fly_by_voxels<M>(*l.grid, at.x, at.y, l.thickness - at.z, wi, remaining);
              return fly<M>(*l.grid, at.x, at.y, l.thickness - at.z, wi, remaining, stream);
            },
            l.grid->palette()[0]);
      } else {
        flight.length = (down ? l.thickness - at.z : at.z) / std::abs(wi.z);
        const double extinction = l.density * sigma(*l.medium, wi);
        if (extinction > 0) {
          const double free = remaining / extinction;
          if (free < flight.length) {
            flight.end = Flight::collided;
            flight.length = free;
          } else {
            remaining = std::max(remaining - extinction * flight.length, 1e-300);
          }
        }
      }
      endless = flight.end == Flight::endless;
      if (endless || !std::isfinite(flight.length)) break;  // in a half space: for good
      at.x -= wi.x * flight.length;
      at.y -= wi.y * flight.length;
      if (!(at.x >= 0 && at.x < stack.tile_x))
        at.x -= stack.tile_x * std::floor(at.x / stack.tile_x);
      if (!(at.y >= 0 && at.y < stack.tile_y))
        at.y -= stack.tile_y * std::floor(at.y / stack.tile_y);
      if (flight.end == Flight::collided) {
        at.z = std::clamp(at.z + wi.z * flight.length, 0.0, l.thickness);
        break;
      }
      at.layer += down ? 1 : -1;
      if (at.layer >= 0 && at.layer <= last) at.z = down ? 0 : stack.layers[at.layer].thickness;
    }

    const bool collides = flight.end == Flight::collided;
    if (!endless && !collides && !(down && stack.has_substrate)) {  // leaves the stack
      weight.leave(energy, down, order, only_delta);
      tell_departure(scorer, -wi, weight.value, order, only_delta);
      if (!only_delta) scorer.leave(-wi, weight.value, order, last_delta);
      break;
    }
    if (endless || order == stack.max_order) {
      weight.add_to(energy.unresolved);
      break;
    }
    ++order;

    if (!collides) {  // the substrate
      only_delta = last_delta = false;
      std::array<double, C> kept;
      for (int c = 0; c < C; ++c) kept[c] = stack.substrate_albedo[c];
      at.layer = last;
      at.z = stack.layers[last].thickness;
      lattice.put(order, kEventWord, stream);
      const Direction wo = kLambertSubstrate.sample(stream).wo;
      scorer.event(at, kLambertSubstrate, weight.value, nullptr, kept, order, lattice, stream);
      if (!weight.survives(kept, order, energy, stream)) break;
      wi = -wo;
      continue;
    }

    ++tally.collisions;
    const GridWalkLayer& l = stack.layers[at.layer];
    std::array<double, C> albedo;
    for (int c = 0; c < C; ++c) albedo[c] = l.albedo[c];
    Frame<double> frame;
    const bool turned = l.grid && l.grid->has_orientation();
    const Medium* medium = l.medium;
    if (l.grid) {
      medium = &l.grid->palette()[l.grid->palette_index(flight.voxel)];
      if (turned) frame = frame_around(normalized(l.grid->axis(flight.voxel)));
      if (l.grid->has_albedo()) {
        const auto a = l.grid->albedo(flight.voxel);
        for (int c = 0; c < C; ++c) albedo[c] *= a[c];
      }
    }
    const bool alive = std::visit(
        [&](const auto& m) {
          lattice.put(order, kEventWord, stream);
          const TurnedEvent event{m.collide(turned ? frame.to_local(wi) : wi, stream),
                                  turned ? &frame : nullptr};
          const Scatter scatter = event.sample(stream);
          last_delta = m.is_delta();
          if (!last_delta) {
            only_delta = false;
            scorer.event(at, event, weight.value, &l, albedo, order, lattice, stream);
          }
          const auto kept = kept_shares<C>(albedo, l, scatter.schlick);
          if (!weight.survives(kept, order, energy, stream)) return false;
          wi = -scatter.wo;
          return true;
        },
        *medium);
    if (!alive) break;
  }
  ++tally.walks;
  double check = wi.x + wi.y + wi.z + at.x + at.y + at.z;
  for (int c = 0; c < C; ++c) check += weight.value[c];
  if (!std::isfinite(check) || !scorer.finite()) throw NonFiniteError(seed, index, incident);
}

template <int C>
RunBatch runner_of(const std::shared_ptr<const GridWalkStack>& stack, Direction incident,
                   std::uint64_t seed, Estimator estimator, const CellTargets& targets,
                   const std::vector<Direction>* points, const Plan& plan,
                   std::vector<BatchTally>& batches) {
  const auto lattice =
      plan.sampling == Sampling::rqmc ? std::make_shared<const WalkLattice>(seed) : nullptr;
  const auto with = [&](const auto& make_scorer) {
    return batches_of_walks(
        seed, batches, make_scorer, [=](std::uint64_t index, auto& scorer, BatchTally& tally) {
          walk_in_grids<C>(*stack, incident, seed, index,
                           lattice ? lattice->point(index) : WalkLattice::Point(), scorer, tally);
        });
  };
  if (points && points->empty()) return with([](int) { return GridNullScorer<C>(); });
  if (!points && estimator == Estimator::analog)
    return with([&targets, &batches](int batch) {
      return GridAnalogScorer<C>{AnalogScorer<C>(targets, batches[batch])};
    });
  const auto tables = std::make_shared<const ShadowTables>(plan.isa, stack->owned);
  if (points)
    return with([=, &batches](int batch) {
      return GridNextEventScorer<C>(*stack, *tables, seed, *points, batches[batch]);
    });
  return with([=, &targets, &batches](int batch) {
    return GridNextEventScorer<C>(*stack, *tables, seed, targets, lattice.get(), batches[batch]);
  });
}

}  // namespace

FollowWalk grid_follower(const Stack& stack, const Plan& plan, std::uint64_t seed) {
  const auto walked = std::make_shared<const GridWalkStack>(stack, plan);
  const auto with = [&]<int C>(std::integral_constant<int, C>) -> FollowWalk {
    return [walked, seed](Direction wi, std::uint64_t index, WalkSamples& to) {
      GridDepartures<C> scorer(wi, to);
      BatchTally spare;
      walk_in_grids<C>(*walked, wi, seed, index, {}, scorer, spare);
    };
  };
  return plan.channels == 1 ? with(std::integral_constant<int, 1>())
                            : with(std::integral_constant<int, 3>());
}

GridRunner grid_runner(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
                       Estimator estimator, const CellTargets& targets,
                       const std::vector<Direction>* points, std::vector<BatchTally>& batches) {
  check_beside_grids("w_i", incident);
  if (points)
    for (const Direction& wo : *points) check_beside_grids("w_o", wo);
  if (points ? points->empty() : estimator == Estimator::analog)
    if (const std::shared_ptr<const GridLaneRun> lanes =
            GridLaneRun::make(stack, plan, incident, seed, points ? nullptr : &targets))
      return {[=, &batches](int batch, std::uint64_t from, std::uint64_t to) {
                lanes->count(batch, from, to, batches[batch]);
              },
              plan.isa};
  const auto walked = std::make_shared<const GridWalkStack>(stack, plan);
  return {plan.channels == 1
              ? runner_of<1>(walked, incident, seed, estimator, targets, points, plan, batches)
              : runner_of<3>(walked, incident, seed, estimator, targets, points, plan, batches)};
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): std::function owns the runner

}  // namespace lamella
