#include "volume/harmonics/beam_quadrature.h"

#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {

namespace {

struct Ray {
  Direction across;  // unit, from the beam
  double weight;     // [radians] of azimuth
};

// Even steps of the azimuth, where the beam is steep. Where it grazes, a ray's cut at the horizon
// moves from one end of the ray to the other within about the beam's cosine of the two horizontal
// rays: there points crowd like sinh about both.
std::vector<Ray> rays_about(Direction along, int count) {
  constexpr double kSteep = 0.3;
  std::vector<Ray> rays;
  const double steep = std::abs(along.z);
  if (steep > kSteep) {
    const Frame<double> frame = frame_around(along);
    for (int k = 0; k < count; ++k) {
      const double psi = 2 * kPi * (k + 0.5) / count;
      rays.push_back({std::cos(psi) * frame.s + std::sin(psi) * frame.t, 2 * kPi / count});
    }
    return rays;
  }
  const Direction up = normalized(Direction{0, 0, 1} - along.z * along), beside = cross(along, up);
  const double reach = std::asinh(kPi / 2 / steep);
  const Quadrature& rule = cached_gauss_legendre(count / 4 + static_cast<int>(4 * reach));
  for (const double place : {kPi / 2, 3 * kPi / 2})
    for (const double sign : {-1.0, 1.0})
      for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
        const double u = reach * rule.points[k], psi = place + sign * steep * std::sinh(u);
        rays.push_back({std::cos(psi) * up + std::sin(psi) * beside,
                        rule.weights[k] * reach * steep * std::cosh(u)});
      }
  return rays;
}

}  // namespace

BeamQuadrature::BeamQuadrature(Direction along, int points, int rays) {
  const Quadrature& rule = cached_gauss_legendre(points);
  for (const auto& [across, azimuth_weight] : rays_about(along, rays)) {
    // along cos r + across sin r crosses the horizon once on the way to the opposite of along.
    double cut = std::atan2(-along.z, across.z);
    if (cut < 0) cut += kPi;
    // t^2 at both ends.
    for (const double from : {0.0, kPi})
      for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
        const double t = rule.points[k];
        const double r = from + (cut - from) * t * t * (3 - 2 * t);
        directions.push_back(std::cos(r) * along + std::sin(r) * across);
        weights.push_back(azimuth_weight * rule.weights[k] * 6 * t * (1 - t) *
                          std::abs(cut - from) * std::abs(std::sin(r)));
      }
  }
}

}  // namespace lamella
