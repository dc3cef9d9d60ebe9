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
  with_lane_medium(t.walk, 0, [&]<template <class> class M>() {
    if constexpr (M<Floats>::kKind != LaneMediumKind::substrate) walk_medium<M>(t);
  });
}

}  // namespace lamella::LAMELLA_ISA
