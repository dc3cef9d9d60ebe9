#include "volume/lanes/lane_replay.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "phase/random/random.h"
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

template <int C>
void replay_walk(const LaneSetting<double>& setting, Thinning thinning, std::uint64_t index,
                 int channels, const CellTargets& cells, BatchTally& tally) {
  const AnyMedia<double> set(setting.walk);
  LaneState<double, C> w{};
  w.numbers = numbers_of(setting.walk.seed, index);
  LaneEnds<double> now{};
  EnergySums& energy = tally.energy;
  const bool collides = begin<C>(setting.walk, set, w, true);
  while (collides && !now.ends) {
    now = step(setting.walk, set, w, true, NoScore{});
    tally.collisions += now.events && !now.reflections && w.order <= setting.walk.max_order;
  }
  ++tally.walks;
  const LaneEnd<std::uint32_t> of(w.order, now.gone, w.wi.z > 0, setting.walk.max_order);
  const auto end = static_cast<WalkEnd>(of.end);
  const bool straight = of.order == 0 && end < WalkEnd::absorbed;
  // What it stood for; where an event both absorbs and halves, the mean of that.
  double standing = thinning.weight(of.order);
  if (end == WalkEnd::absorbed && (C > 0 ? w.order >= w.death : thinning.halves_at(of.order))) {
    const double albedo = *std::max_element(setting.albedo.begin(), setting.albedo.end());
    standing *= C > 0 || of.order < kRouletteOrder ? 0 : (1 - albedo) / (2 - albedo);
  }
  const int target = straight || end > WalkEnd::down ? -1 : cells.find(-w.wi);
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
    const int slot = order_slot(of.order);
    (end == WalkEnd::up ? energy.up : energy.down)[slot][c] += weight;
    if (target >= 0)
      tally.f[static_cast<std::size_t>(slot * channels + c) * cells.count() + target] +=
          weight / cells.grid.projected_solid_angle();
  }
}

}  // namespace

std::vector<BatchTally> replay_in_double(const Stack& stack, const Plan& plan, Direction incident,
                                         std::uint64_t seed, int batches, std::uint64_t walks,
                                         const CellTargets& cells) {
  const LaneSetting<double> setting(stack, plan, incident, seed);
  std::vector<BatchTally> tallies(batches);
  tbb::parallel_for(0, batches, [&](int batch) {
    BatchTally& tally = tallies[batch];
    tally.f.resize(static_cast<std::size_t>(kTallyOrders) * plan.channels * cells.count());
    for (std::uint64_t i = batch; i < walks; i += batches)
      (setting.common_albedo ? replay_walk<0> : replay_walk<3>)(setting, plan.thinning, i,
                                                                plan.channels, cells, tally);
  });
  return tallies;
}

}  // namespace lamella
