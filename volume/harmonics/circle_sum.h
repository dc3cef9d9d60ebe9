#pragma once

#include "volume/harmonics/circle_task.h"

namespace lamella {

/// What circle_sum_lanes does, with doubles: the same but for rounding.
void circle_sum(const CircleTask& task);

}  // namespace lamella
