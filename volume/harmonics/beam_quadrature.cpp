#include "volume/harmonics/beam_quadrature.h"

#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {

BeamQuadrature::BeamQuadrature(Direction along, int points, int rays) {
  const Frame<double> frame = frame_around(along);
  const Quadrature& rule = cached_gauss_legendre(points);
  for (int ray = 0; ray < rays; ++ray) {
    const double psi = 2 * kPi * (ray + 0.5) / rays;
    const Direction across = std::cos(psi) * frame.s + std::sin(psi) * frame.t;
    // along cos r + across sin r crosses the horizon once on the way to the opposite of along.
    double cut = std::atan2(-along.z, across.z);
    if (cut < 0) cut += kPi;
    const auto add = [&](double from, double to, bool both) {
      // From 0 to 1: t^2 at the end, and at the beginning where `both`.
      for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
        const double t = rule.points[k];
        const double part = both ? t * t * (3 - 2 * t) : t * (2 - t);
        const double slope = both ? 6 * t * (1 - t) : 2 * (1 - t);
        const double r = from + (to - from) * part;
        Direction v = std::cos(r) * along + std::sin(r) * across;
        directions.push_back(v);
        weights.push_back(2 * kPi / rays * rule.weights[k] * slope * std::abs(to - from) *
                          std::abs(std::sin(r)));
      }
    };
    add(0, cut, true);
    add(kPi, cut, true);
  }
}

}  // namespace lamella
