// Walks through stacks of any media, with or without weights.

#include "volume/lane_points.h"

namespace lamella::LAMELLA_ISA {
namespace {

template <int C>
void walk_stack(const LaneWalkTask& t, LaneSums& sums) {
  walks_of<C, AnyMedia<Floats>>(t, sums, NextEventOnLanes<C>{t, sums});
}

}  // namespace

void walk_stack_lanes(const LaneWalkTask& t, LaneSums& sums) {
  return t.weights ? walk_stack<3>(t, sums) : walk_stack<0>(t, sums);
}

}  // namespace lamella::LAMELLA_ISA
