#include "phase/medium/lambert_sphere.h"

#include <boost/math/tools/roots.hpp>

namespace lamella {

double lambert_sphere_cdf(double cosine) {
  const double theta = std::acos(cosine);
  // The three terms cancel to fifth order at small deflection.
  const double t2 = theta * theta;
  const double less =
      theta < 0.05
          ? 4 * t2 * t2 * theta * (1 + t2 * (-4.0 / 21 + t2 / 63)) / (45 * kPi)
          : (2 * theta + theta * std::cos(2 * theta) - 1.5 * std::sin(2 * theta)) / (3 * kPi);
  return 1 - less;
}

double lambert_sphere_cosine_fit(double u) {
  return 1 - 2 * std::pow(1 - std::pow(u, 0.0401885 * u + 1.01938), 0.397225);
}

double lambert_sphere_cosine_inverse(double u) {
  if (u <= 0) return -1;
  if (u >= 1) return 1;
  const auto residual = [u](double cosine) {
    return std::pair{lambert_sphere_cdf(cosine) - u, 2 * kPi * lambert_sphere_phase(cosine)};
  };
  std::uintmax_t steps = 60;
  return boost::math::tools::newton_raphson_iterate(residual, lambert_sphere_cosine_fit(u), -1.0,
                                                    1.0, 52, steps);
}

}  // namespace lamella
