// Counted walks through one layer of upright vMF flakes: normals by null collisions.

#include "volume/lanes/lane_loop.h"
#include "volume/lanes/lane_null_flakes.h"

namespace lamella::LAMELLA_ISA {
namespace {

template <template <class> class M>
void count_walks(const LaneWalkTask& t) {
  using Set = OneMedium<Floats, M>;
  if (t.asks_for_index())
    walks_of<0, Set>(t, NoScoreByIndex{});
  else
    walks_of<0, Set>(t, NoScore{});
}

}  // namespace

void count_flake_lanes(const LaneWalkTask& t) {
  if (t.walk.kinds == 1u << static_cast<int>(LaneMediumKind::vmf_mirror))
    count_walks<NullVmfMirrorOnLanes>(t);
  else
    count_walks<NullVmfLambertOnLanes>(t);
}

}  // namespace lamella::LAMELLA_ISA
