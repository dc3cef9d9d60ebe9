#pragma once

#include "phase/stack/stack.h"

namespace lamella {

/// w_i of walks through a stack, mu = 0 as the limit from above. Throws std::invalid_argument for
/// light from below where that is closed, and on explicit geometry for |mu| below
/// kGrainGrazingLimit; GeometryError without Embree.
[[nodiscard]] Direction checked_incident(const Stack& stack, Direction wi);

}  // namespace lamella
