#pragma once

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

// An integral over a hemisphere whose code shares nothing with analytic/model/directional_integral:
// for smooth functions only, since nothing but the depth of its rules ends it.

/// Integral of g(w) |mu| dw over the upper (side = +1) or lower (side = -1) hemisphere, g a
/// function of a direction with values in double. Nested adaptive Gauss-Kronrod rules in mu and
/// phi, phi split at multiples of pi / 2; relative tolerance per rule.
template <class G>
[[nodiscard]] double integrate_projected(const G& g, double side, double tolerance = 1e-9) {
  using boost::math::quadrature::gauss_kronrod;
  const auto ring = [&](double mu) {
    const auto at = [&](double phi) { return g(direction_from_mu_phi(side * mu, phi)); };
    double sum = 0;
    for (int quarter = 0; quarter < 4; ++quarter)
      sum += gauss_kronrod<double, 15>::integrate(at, quarter * kPi / 2, (quarter + 1) * kPi / 2, 8,
                                                  tolerance);
    return mu * sum;
  };
  return gauss_kronrod<double, 31>::integrate(ring, 0.0, 0.1, 8, tolerance) +
         gauss_kronrod<double, 31>::integrate(ring, 0.1, 1.0, 10, tolerance);
}

/// The same per channel.
template <class G>
[[nodiscard]] Rgb integrate_projected_rgb(const G& g, double side, double tolerance = 1e-9) {
  Rgb sum;
  for (int c = 0; c < 3; ++c)
    sum[c] = integrate_projected([&](Direction w) { return g(w)[c]; }, side, tolerance);
  return sum;
}

}  // namespace lamella
