#include "volume/lanes/lane_replay.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "phase/random/random.h"
#include "volume/lanes/lane_null_flakes.h"
#include "volume/lanes/lane_setting.h"

namespace lamella {
namespace {

WalkNumbers<std::uint32_t> numbers_of(std::uint64_t seed, std::uint64_t index) {
  const auto block = r123::Philox4x32_R<7>()(
      {{0, kLaneWalkStream, static_cast<std::uint32_t>(index),
        static_cast<std::uint32_t>(index >> 32)}},
      {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}});
  const WordBlock<std::uint32_t> state{{block.v[0], block.v[1], block.v[2], block.v[3]}};
  return WalkNumbers<std::uint32_t>(state);
}

// One walk through a stack with interfaces; its row of ends, see lane_state.h.
template <int C>
int replay_bounded(const WalkSetting<double>& walk, BoundedState<double, C>& w,
                   LaneEnds<double>& now, BatchTally& tally) {
  const BoundedMedia<double> set(walk);
  if (!begin<C>(walk, set, static_cast<LaneState<double, C>&>(w), true))
    return straight_row<true>(walk.from_above);
  for (;;) {
    double remaining = 0;
    if (set.is_at_boundary(w.layer)) {
      std::uint32_t words[kMostBoundaryWords];
      draw_meeting<double, C>(walk, walk.boundaries->words, true, w, words);
      const BoundaryEnds<double> at = meet<AnyBoundaries, double, C>(walk, w, words, true);
      if (at.lost) return kLostRow;
      if (at.cut) return static_cast<int>(WalkEnd::unresolved);
      if (at.out) break;
      remaining = exponential_of(words[0]);
    } else {
      LaneDraws<double> draws;
      draw<C>(walk, set, w, draws);
      now = scatter<C>(walk, set, w, draws, true, NoScore{});
      if (now.events) w.met = 0;
      tally.collisions += now.events && !now.reflections && w.order <= walk.max_order;
      if (now.gone) break;
      remaining = draws.remaining;
    }
    if (!set.fly(w.wi, remaining, true, w.layer, w.y)) break;
  }
  const LaneEnd<std::uint32_t> of(w.order, now.gone, w.wi.z > 0, walk.max_order);
  const bool deltas = of.order == 0 && (w.met & 1) == 0 && of.end < 2;
  return static_cast<int>(of.end) + (deltas ? kDeltaRow : 0);
}

// `point`: r(j) of the walk, where there is a lattice.
template <int C>
void replay_walk(const LaneSetting<double>& setting, const LatticeNumbers* lattice,
                 Thinning thinning, std::uint64_t index, std::uint32_t point, int channels,
                 const CellTargets& cells, BatchTally& tally) {
  BoundedState<double, C> w{};
  w.numbers = numbers_of(setting.walk.seed, index);
  w.point = point;
  WalkSetting<double> walk = setting.walk;
  walk.lattice = lattice;
  LaneEnds<double> now{};
  EnergySums& energy = tally.energy;
  const bool bounded = setting.walk.boundaries != nullptr;
  int row = 0;
  if (bounded) {
    row = replay_bounded<C>(walk, w, now, tally);
  } else {
    LaneState<double, C>& state = w;
    const auto walk_through = [&](const auto& set) {
      const bool collides = begin<C>(walk, set, state, true);
      while (collides && !now.ends) {
        now = step(walk, set, state, true, NoScore{});
        tally.collisions += now.events && !now.reflections && w.order <= setting.walk.max_order;
      }
    };
    if (!walk.null_collisions)
      walk_through(AnyMedia<double>(walk));
    else if (walk.kinds == 1u << static_cast<int>(LaneMediumKind::vmf_mirror))
      walk_through(OneMedium<double, NullVmfMirrorOnLanes>(walk));
    else
      walk_through(OneMedium<double, NullVmfLambertOnLanes>(walk));
  }
  ++tally.walks;
  LaneEnd<std::uint32_t> of(w.order, now.gone, w.wi.z > 0, setting.walk.max_order);
  const bool lost = row == kLostRow, deltas = row >= kDeltaRow;
  if (bounded) of.end = static_cast<std::uint32_t>(lost ? 0 : deltas ? row - kDeltaRow : row);
  const auto end = static_cast<WalkEnd>(of.end);
  const bool down = end == WalkEnd::down;
  const bool straight = of.order == 0 && end < WalkEnd::absorbed && !lost &&
                        (!bounded || (deltas && down == setting.walk.from_above));
  // What it stood for; where an event both absorbs and halves, the mean of that.
  double standing = thinning.weight(of.order);
  if (end == WalkEnd::absorbed && (C > 0 ? w.order >= w.death : thinning.halves_at(of.order))) {
    const double albedo = *std::max_element(setting.albedo.begin(), setting.albedo.end());
    standing *= C > 0 || of.order < kRouletteOrder ? 0 : (1 - albedo) / (2 - albedo);
  }
  const int target = straight || deltas || lost || end > WalkEnd::down ? -1 : cells.find(-w.wi);
  for (int c = 0; c < channels; ++c) {
    const double at_end = C > 0 ? w.weight[C > 0 ? c : 0] : setting.weight_after(c, of.order);
    const double weight = setting.chance * (straight ? 1 : at_end * thinning.weight(of.order));
    energy.uncollided[c] += 1 - setting.chance;
    if (straight) {
      energy.uncollided[c] += weight;
      continue;
    }
    energy.thinned[c] += setting.chance * (1 - standing);
    energy.absorbed[c] += setting.chance * standing - (end == WalkEnd::absorbed ? 0 : weight);
    if (end == WalkEnd::unresolved) energy.unresolved[c] += weight;
    if (end > WalkEnd::down) continue;
    if (lost) {
      energy.lost[c] += weight;
      continue;
    }
    const int slot = order_slot(of.order);
    if (deltas) (down ? energy.specular_down : energy.specular_up)[c] += weight;
    if (slot == kZeroSlot)
      (down ? energy.zero_down : energy.zero_up)[c] += weight;
    else
      (down ? energy.down : energy.up)[slot][c] += weight;
    if (target >= 0)
      tally.f[static_cast<std::size_t>(slot * channels + c) * cells.count() + target] +=
          weight / cells.grid.projected_solid_angle();
  }
}

}  // namespace

std::vector<BatchTally> replay_in_double(const Stack& stack, const Plan& plan, Direction incident,
                                         std::uint64_t seed, int batches, std::uint64_t walks,
                                         const CellTargets& cells) {
  const LaneSetting<double> setting(stack, plan, incident, seed, true);
  std::vector<BatchTally> tallies(batches);
  tbb::parallel_for(0, batches, [&](int batch) {
    BatchTally& tally = tallies[batch];
    tally.f.resize(static_cast<std::size_t>(plan.order_slots()) * plan.channels * cells.count());
    LatticeNumbers lattice{};
    const bool has_lattice = plan.sampling == Sampling::rqmc;
    for (std::uint64_t j = 0; batch + j * batches < walks; ++j) {
      const std::uint32_t number = lattice_point(j);
      if (has_lattice && number == 0)
        lattice = lattice_of_batch(lattice_shift(seed, static_cast<std::uint32_t>(batch), j));
      (setting.common_albedo ? replay_walk<0>
                             : replay_walk<3>)(setting, has_lattice ? &lattice : nullptr,
                                               plan.thinning, batch + j * batches,
                                               reversed_bits(number), plan.channels, cells, tally);
    }
  });
  return tallies;
}

}  // namespace lamella
