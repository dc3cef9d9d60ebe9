#include "volume/harmonics/beam_quadrature.h"

#include <algorithm>
#include <cmath>

#include "volume/quadrature/quadrature.h"

namespace lamella {

namespace {

struct Ray {
  Direction across;  // unit, from the beam
  double weight;     // [radians] of azimuth
};

// A quarter of the rays: from a horizontal one, at `place`, towards the steepest one. Where the
// beam grazes, a ray's cut at the horizon moves from one end of the ray to the other within about
// the beam's cosine of the horizontal rays: there points crowd like sinh. tangent: distances from
// the horizontal ray at which rays only touch a cone, where integrals over them go like a root.
void add_quarter(std::vector<Ray>& rays, Direction along, double place, double sign, int count,
                 const std::vector<double>& tangent) {
  const double steep = std::abs(along.z), reach = std::asinh(kPi / 2 / steep);
  const Direction up = normalized(Direction{0, 0, 1} - along.z * along), beside = cross(along, up);
  std::vector<double> ends{0};
  for (const double distance : tangent) ends.push_back(std::asinh(distance / steep));
  ends.push_back(reach);
  const int all = count / 4 + static_cast<int>(4 * reach);
  for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
    const double length = ends[part + 1] - ends[part];
    const bool is_smooth = tangent.empty();
    constexpr int kFewest = 12;
    const Quadrature& rule =
        cached_gauss_legendre(is_smooth ? all : kFewest + static_cast<int>(all * length / reach));
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      // t^2 at both ends.
      const double t = rule.points[k], share = is_smooth ? t : t * t * (3 - 2 * t);
      const double u = ends[part] + length * share, psi = place + sign * steep * std::sinh(u);
      rays.push_back(
          {std::cos(psi) * up + std::sin(psi) * beside,
           rule.weights[k] * (is_smooth ? 1 : 6 * t * (1 - t)) * length * steep * std::cosh(u)});
    }
  }
}

// Even steps of the azimuth, where the beam is steep and no ray touches a cone.
std::vector<Ray> rays_about(Direction along, int count, const std::vector<double>& cuts,
                            bool is_even) {
  constexpr double kSteep = 0.3;
  std::vector<Ray> rays;
  std::vector<double> tangent;
  const double steep = std::abs(along.z);
  for (const double mu : cuts)
    if (mu > steep)
      tangent.push_back(
          std::asin(std::sqrt((mu - steep) * (mu + steep)) / std::sqrt((1 - steep) * (1 + steep))));
  std::sort(tangent.begin(), tangent.end());
  if (steep > kSteep && tangent.empty()) {
    Frame<double> frame = frame_around(along);
    if (is_even) {
      frame.t = {0, 1, 0};
      frame.s = cross(frame.t, along);
    }
    for (int k = 0; k < (is_even ? count / 2 : count); ++k) {
      const double psi = 2 * kPi * (k + 0.5) / count;
      rays.push_back({std::cos(psi) * frame.s + std::sin(psi) * frame.t, 2 * kPi / count});
    }
  } else {
    for (const double place : {kPi / 2, 3 * kPi / 2})
      for (const double sign : {-1.0, 1.0})
        if (!is_even || place < kPi) add_quarter(rays, along, place, sign, count, tangent);
  }
  if (is_even)
    for (Ray& ray : rays) ray.weight *= 2;
  return rays;
}

}  // namespace

BeamQuadrature::BeamQuadrature(Direction along, int points, int rays,
                               const std::vector<double>& cuts, bool is_even) {
  const Quadrature& rule = cached_gauss_legendre(points);
  for (const auto& [across, azimuth_weight] : rays_about(along, rays, cuts, is_even)) {
    // along cos r + across sin r crosses the horizon once on the way to the opposite of along.
    double cut = std::atan2(-along.z, across.z);
    if (cut < 0) cut += kPi;
    std::vector<double> ends{0, cut, kPi};
    // The height along the ray is amplitude cos(r - highest).
    const double amplitude = std::hypot(along.z, across.z);
    const double highest = std::atan2(across.z, along.z);
    for (const double mu : cuts)
      for (const double height : {mu, -mu})
        for (const double sign : {1.0, -1.0}) {
          if (!(std::abs(height) < amplitude)) continue;
          double r = std::fmod(highest + sign * std::acos(height / amplitude), 2 * kPi);
          if (r < 0) r += 2 * kPi;
          if (r < kPi) ends.push_back(r);
        }
    std::sort(ends.begin(), ends.end());
    // t^2 at both ends.
    for (std::size_t part = 0; part + 1 < ends.size(); ++part)
      for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
        const double t = rule.points[k], length = ends[part + 1] - ends[part];
        const double r = ends[part] + length * t * t * (3 - 2 * t);
        directions.push_back(std::cos(r) * along + std::sin(r) * across);
        weights.push_back(azimuth_weight * rule.weights[k] * 6 * t * (1 - t) * length *
                          std::abs(std::sin(r)));
      }
  }
}

}  // namespace lamella
