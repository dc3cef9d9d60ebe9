// Walks through one layer of one medium, its kernel known at compile time.

#include "volume/lane_points.h"

namespace lamella::LAMELLA_ISA {
namespace {

template <template <class> class M>
void walk_medium(const LaneWalkTask& t, LaneSums& sums) {
  using Set = OneMedium<Floats, M>;
  if (t.estimate == LaneEstimate::points || t.estimate == LaneEstimate::cells_next_event)
    walks_of<0, Set>(t, sums, NextEventOnLanes<0>{t, sums});
  else
    walks_of<0, Set>(t, sums, NoScore{});
}

}  // namespace

void walk_lanes(const LaneWalkTask& t, LaneSums& sums) {
  switch (static_cast<LaneMediumKind>(static_cast<int>(t.walk.layers->value[kKind][0]))) {
    case LaneMediumKind::lambert_sphere:
      return walk_medium<LambertSphereOnLanes>(t, sums);
    case LaneMediumKind::henyey_greenstein:
      return walk_medium<HenyeyGreensteinOnLanes>(t, sums);
    case LaneMediumKind::sggx_mirror:
      return t.walk.upright ? walk_medium<UprightSggxMirrorOnLanes>(t, sums)
                            : walk_medium<SggxMirrorOnLanes>(t, sums);
    case LaneMediumKind::sggx_lambert:
      return t.walk.upright ? walk_medium<UprightSggxLambertOnLanes>(t, sums)
                            : walk_medium<SggxLambertOnLanes>(t, sums);
    case LaneMediumKind::vmf_mirror:
      return walk_medium<VmfMirrorOnLanes>(t, sums);
    case LaneMediumKind::vmf_lambert:
      return walk_medium<VmfLambertOnLanes>(t, sums);
    case LaneMediumKind::substrate:
      break;  // is no layer
  }
}

}  // namespace lamella::LAMELLA_ISA
