#include "phase/math/degrees.h"

#include <cmath>

namespace lamella {

double theta_degrees(Direction w) {
  const double theta = std::atan2(std::hypot(w.x, w.y), w.z) * 180 / kPi;
  return std::round(theta * 1e9) / 1e9;
}

double phi_degrees(Direction w) {
  if (w.x == 0 && w.y == 0) return 0;
  return std::round(azimuth(w) * 180 / kPi * 1e9) / 1e9;
}

}  // namespace lamella
