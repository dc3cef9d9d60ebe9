// Walks through stacks of any media, with or without weights: all lanes in one layer at a time.

#include "volume/lanes/lane_layer_loop.h"
#include "volume/lanes/lane_next_event.h"

namespace lamella::LAMELLA_ISA {

void walk_layered_lanes(const LaneWalkTask& t) {
  if (t.weights)
    layered_walks_of<3>(t, NextEventOnLanes<3>{t});
  else
    layered_walks_of<0>(t, NextEventOnLanes<0>{t});
}

}  // namespace lamella::LAMELLA_ISA
