// Walks through stacks with interfaces, with or without weights.

#include "volume/lanes/lane_coat_loop.h"

namespace lamella::LAMELLA_ISA {
namespace {

using Set = BoundedMedia<Floats>;
using Score = NoScoreByIndex;

template <template <class> class M>
void walk_medium(const LaneWalkTask& t) {
  return queued_walks_of<0, Set, Score, OneMedium<Floats, M, true>>(t, Score{});
}

// One layer without weights, of a medium that is known in advance. Whether it is one of them.
bool walk_one_layer(const LaneWalkTask& t) {
  switch (static_cast<LaneMediumKind>(static_cast<int>(t.walk.layers->value[kKind][0]))) {
    case LaneMediumKind::lambert_sphere:
      walk_medium<LambertSphereOnLanes>(t);
      return true;
    case LaneMediumKind::henyey_greenstein:
      walk_medium<HenyeyGreensteinOnLanes>(t);
      return true;
    case LaneMediumKind::vmf_lambert:
      t.walk.narrow ? walk_medium<NarrowVmfLambertOnLanes>(t) : walk_medium<VmfLambertOnLanes>(t);
      return true;
    default:
      return false;
  }
}

}  // namespace

void walk_bounded_lanes(const LaneWalkTask& t) {
  const unsigned substrate = 1u << static_cast<int>(LaneMediumKind::substrate);
  const bool has_media = (t.walk.kinds & ~substrate) != 0;
  if (!has_media && !t.weights && !t.asks_for_index()) {
    if (coated_walks_of<BetaGgx, Set>(t) || coated_walks_of<CorrelatedGgx, Set>(t)) return;
    return unscattered_walks_of<0, Set>(t, NoScore{});
  }
  if (!has_media)
    return t.weights ? unscattered_walks_of<3, Set>(t, Score{})
                     : unscattered_walks_of<0, Set>(t, Score{});
  if (!t.weights && !t.walk.substrate && t.walk.layer_count == 1 && walk_one_layer(t)) return;
  return t.weights ? queued_walks_of<3, Set>(t, Score{}) : queued_walks_of<0, Set>(t, Score{});
}

}  // namespace lamella::LAMELLA_ISA
