// Walks through one layer of one medium, its kernel known at compile time.

#include "volume/lanes/lane_next_event.h"

namespace lamella::LAMELLA_ISA {
namespace {

template <template <class> class M>
void walk_medium(const LaneWalkTask& t) {
  using Set = OneMedium<Floats, M>;
  if (t.estimate == LaneEstimate::points || t.estimate == LaneEstimate::cells_next_event)
    walks_of<0, Set>(t, NextEventOnLanes<0>{t});
  else if (t.asks_for_index())
    walks_of<0, Set>(t, NoScoreByIndex{});
  else
    walks_of<0, Set>(t, NoScore{});
}

}  // namespace

void walk_lanes(const LaneWalkTask& t) {
  switch (static_cast<LaneMediumKind>(static_cast<int>(t.walk.layers->value[kKind][0]))) {
    case LaneMediumKind::lambert_sphere:
      return walk_medium<LambertSphereOnLanes>(t);
    case LaneMediumKind::henyey_greenstein:
      return walk_medium<HenyeyGreensteinOnLanes>(t);
    case LaneMediumKind::rayleigh:
      return walk_medium<RayleighOnLanes>(t);
    case LaneMediumKind::sggx_mirror:
      return t.walk.upright ? walk_medium<UprightSggxMirrorOnLanes>(t)
                            : walk_medium<SggxMirrorOnLanes>(t);
    case LaneMediumKind::sggx_lambert:
      return t.walk.upright ? walk_medium<UprightSggxLambertOnLanes>(t)
                            : walk_medium<SggxLambertOnLanes>(t);
    case LaneMediumKind::vmf_mirror:
      return walk_medium<VmfMirrorOnLanes>(t);
    case LaneMediumKind::vmf_lambert:
      return walk_medium<VmfLambertOnLanes>(t);
    case LaneMediumKind::substrate:
      break;  // is no layer
  }
}

}  // namespace lamella::LAMELLA_ISA
