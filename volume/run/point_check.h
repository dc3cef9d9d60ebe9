#pragma once

#include "phase/stack/stack.h"

namespace lamella {

/// Throws std::invalid_argument where next-event estimation at points would leave light out: delta
/// flakes beside anything that scatters, whose light they may send to a point where nothing can
/// aim. Delta flakes alone have no f beside their deltas.
void require_aimable(const Stack& stack);

}  // namespace lamella
