#pragma once

#include "volume/lanes/lane_task.h"

namespace lamella {

/// The loop of walks on lanes that a task takes.
using LaneLoop = void (*)(const LaneWalkTask&);
[[nodiscard]] inline LaneLoop lane_loop_of(const LaneWalkTask& task, Isa isa) {
  return task.walk.boundaries        ? walk_bounded_lanes_for(isa)
         : task.walk.null_collisions ? count_flake_lanes_for(isa)
         : task.one_medium           ? walk_lanes_for(isa)
         : task.walk.by_layer        ? walk_layered_lanes_for(isa)
                                     : walk_stack_lanes_for(isa);
}

}  // namespace lamella
