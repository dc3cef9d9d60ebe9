#include "phase/math/direction.h"

#include <algorithm>
#include <boost/math/special_functions/cos_pi.hpp>
#include <boost/math/special_functions/sin_pi.hpp>

namespace lamella {

Direction direction_from_mu_phi(double mu, double phi) {
  const double s = std::sqrt(std::max(0.0, (1 - mu) * (1 + mu)));
  return {s * std::cos(phi), s * std::sin(phi), mu};
}

Direction direction_from_degrees(double theta, double phi) {
  using boost::math::cos_pi;
  using boost::math::sin_pi;
  const double s = sin_pi(theta / 180);
  if (std::abs(phi) > 1e6) phi = std::fmod(phi, 360);  // beyond 4e11 the library's int ends
  return {s * cos_pi(phi / 180), s * sin_pi(phi / 180), cos_pi(theta / 180)};
}

Direction with_grazing_limit(Direction w) {
  if (std::abs(w.z) < kGrazingLimit) w.z = w.z < 0 ? -kGrazingLimit : kGrazingLimit;
  return w;
}

double azimuth(Direction w) {
  const double phi = std::atan2(w.y, w.x);
  return phi < 0 ? phi + 2 * kPi : phi;
}

}  // namespace lamella
