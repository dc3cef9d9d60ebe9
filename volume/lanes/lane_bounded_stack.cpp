// Walks through stacks with interfaces, with or without weights.

#include "volume/lanes/lane_bounded_loop.h"

namespace lamella::LAMELLA_ISA {

void walk_bounded_lanes(const LaneWalkTask& t) {
  using Set = BoundedMedia<Floats>;
  const unsigned substrate = 1u << static_cast<int>(LaneMediumKind::substrate);
  if ((t.walk.kinds & ~substrate) != 0)
    return t.weights ? queued_walks_of<3, Set>(t, NoScoreByIndex{})
                     : queued_walks_of<0, Set>(t, NoScoreByIndex{});
  return t.weights ? bounded_walks_of<3, Set>(t, NoScoreByIndex{})
                   : bounded_walks_of<0, Set>(t, NoScoreByIndex{});
}

}  // namespace lamella::LAMELLA_ISA
