#include "volume/lane_replay.h"

#include <tbb/parallel_for.h>

#include "phase/random.h"
#include "volume/lane_setting.h"

namespace lamella {
namespace {

struct ReplayNumbers {
  std::uint64_t seed;
  std::uint32_t index_high;
  WordBlock<std::uint32_t> operator()(std::uint32_t position, std::uint32_t stream,
                                      std::uint32_t index) const {
    const auto block = r123::Philox4x32_R<7>()(
        {{position, stream, index, index_high}},
        {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}});
    return {{block.v[0], block.v[1], block.v[2], block.v[3]}};
  }
};

template <int C>
void replay_walk(const LaneSetting<double>& setting, std::uint64_t index, int channels,
                 const CellTargets& cells, BatchTally& tally) {
  const AnyMedia<double> set(setting.walk);
  const ReplayNumbers numbers{setting.walk.seed, static_cast<std::uint32_t>(index >> 32)};
  LaneState<double, C> w{};
  w.index = static_cast<std::uint32_t>(index);
  LaneEnds<double> now{};
  EnergySums& energy = tally.energy;
  const bool collides = begin<C>(setting.walk, set, w, true, numbers);
  while (collides && !now.ends) {
    now = step<C>(setting.walk, set, w, true, NoScore{}, numbers);
    tally.collisions += now.events && !now.reflections;
  }
  ++tally.walks;
  const bool straight = w.order == 0 && (!collides || (now.code & 3) < 2);
  const auto end = static_cast<WalkEnd>(now.code & 3);
  const int target = straight || end > WalkEnd::down ? -1 : cells.find(-w.wi);
  for (int c = 0; c < channels; ++c) {
    const double at_end = C > 0 ? w.weight[C > 0 ? c : 0] : setting.weight_after(c, w.order);
    const double weight = setting.chance * (straight ? 1 : at_end);
    energy.uncollided[c] += 1 - setting.chance;
    if (straight) {
      energy.uncollided[c] += weight;
      continue;
    }
    energy.absorbed[c] += setting.chance - (end == WalkEnd::absorbed ? 0 : weight);
    if (end == WalkEnd::unresolved) energy.unresolved[c] += weight;
    if (end > WalkEnd::down) continue;
    const int slot = order_slot(w.order);
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
      (setting.common_albedo ? replay_walk<0> : replay_walk<3>)(setting, i, plan.channels, cells,
                                                                tally);
  });
  return tallies;
}

}  // namespace lamella
