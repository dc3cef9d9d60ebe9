// Walks through stacks of any media, with or without weights: each lane in its own layer.

#include "volume/lanes/lane_next_event.h"

namespace lamella::LAMELLA_ISA {
namespace {

template <int C>
void walk_stack(const LaneWalkTask& t) {
  walks_of<C, AnyMedia<Floats>>(t, NextEventOnLanes<C>{t});
}

}  // namespace

void walk_stack_lanes(const LaneWalkTask& t) {
  return t.weights ? walk_stack<3>(t) : walk_stack<0>(t);
}

}  // namespace lamella::LAMELLA_ISA
