#pragma once

#include "phase/math/direction.h"

namespace lamella {

/// Polar angle of w in degrees, in [0, 180], rounded to 1e-9: what a user typed comes back.
[[nodiscard]] double theta_degrees(Direction w);

/// Azimuth of w in degrees, in [0, 360), rounded to 1e-9; 0 on the axis.
[[nodiscard]] double phi_degrees(Direction w);

}  // namespace lamella
