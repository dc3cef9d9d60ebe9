#pragma once

#include <cmath>

#include "analytic/facets/adaptive_rule.h"
#include "phase/math/direction.h"
#include "phase/surface/fresnel_formulas.h"
#include "phase/surface/microfacet.h"

namespace lamella {

/// The smallest alpha that closed forms take; smaller ones count as smooth in models that have a
/// smooth case.
inline constexpr double kLeastRoughness = 1e-4;

/// Which of the facets that a direction sees an integral runs over.
enum class SeenFacets {
  all,
  reflecting  ///< those that mirror the direction to above the surface
};

/// The cosine beyond which a boundary of that relative index reflects everything; 0: none.
[[nodiscard]] inline double critical_cosine(double ratio) {
  return ratio < 1 ? std::sqrt((1 - ratio) * (1 + ratio)) : 0;
}

/// The average of g over the facets that light from w, above the surface, meets:
///   integral of D(m) <w, m> / area(w) g(w, m, w . m) dm,
/// with values of Value, a double or an Rgb. Facets that are the same all round are turned until w
/// has the azimuth 0: g receives the turned w. Relative tolerance of the nested rules; slopes of
/// GGX are cut at e^25 alpha. kink: a value of w . m where g is not smooth, the critical angle's,
/// or 0. least: an absolute error that suffices.
///
/// In slopes alpha t along an azimuth phi the visible normals, and those that mirror w to above,
/// are intervals from t = 0, so that neither bound lies inside a panel. t = sinh(v) for GGX (its
/// density is 2 sinh(v) / cosh(v)^3 dv): the integrand has a scale of 1 in v, however small alpha
/// is.
template <class Value, class G>
[[nodiscard]] Value average_over_facets(const Facets& facets, Direction w, SeenFacets which,
                                        const G& g, double tolerance = 1e-8, double kink = 0,
                                        double least = 0) {
  const bool ggx = facets.shape == FacetShape::ggx;
  const double ax = facets.alpha_x, ay = facets.alpha_y;
  const bool turns = ax == ay;
  if (turns) w = {std::sqrt(w.x * w.x + w.y * w.y), 0, w.z};
  const double mu = w.z, area = facets.area(w);
  // The variable of a slope t, no further than where facets are.
  const auto along = [ggx](double t) {
    return ggx ? std::fmin(std::asinh(t), 25) : std::fmin(t, 6.5);
  };
  const auto ring = [&](double phi) {
    const double c = std::cos(phi), s = std::sin(phi);
    const double b = w.x * ax * c + w.y * ay * s;  // w . m / m.z = mu + b t
    const double a = ax * ax * c * c + ay * ay * s * s;
    // Mirrored to above: mu a t^2 - 2 b t - mu < 0.
    const double root = std::sqrt(b * b + mu * mu * a);
    const double mirrors = along(b > 0 ? (b + root) / (mu * a) : mu / (root - b));
    const double sees = along(b < 0 ? mu / -b : 1e300);
    const double end = which == SeenFacets::all ? sees : mirrors;
    std::array<double, 5> edges{0, mirrors, end, end, end};
    if (kink > 0) {
      // (mu + b t)^2 = kink^2 (1 + a t^2)
      const double p = b * b - kink * kink * a, q = mu * b, r = mu * mu - kink * kink;
      const double d = q * q - p * r;
      if (d >= 0 && p != 0) {
        for (const int k : {0, 1}) {
          const double t = (k == 0 ? -q - std::sqrt(d) : -q + std::sqrt(d)) / p;
          if (t > 0 && along(t) < end) edges[2 + k] = along(t);
        }
        std::sort(edges.begin() + 1, edges.end());
      }
    }
    const auto facet = [&](double v) {
      const double t = ggx ? std::sinh(v) : v;
      const double weight =
          2 * t * (ggx ? 1 / ((1 + t * t) * std::sqrt(1 + t * t)) : std::exp(-t * t));
      const double x = ax * t * c, y = ay * t * s;
      const double z = 1 / std::sqrt(1 + x * x + y * y);
      const double shown = std::fmax(mu + b * t, 0);
      return weight * shown * g(w, Direction{x * z, y * z, z}, shown * z);
    };
    return integrate_adaptively<Value>(facet, edges, tolerance / 4, area * least + 1e-300);
  };
  // From the azimuth along which facets face w; across it, at pi / 2, what they show changes within
  // an angle of the order of mu.
  const double facing = std::atan2(w.y * ay, w.x * ax);
  const double across = std::fmin(0.5, 4 * mu / (1e-3 + std::hypot(w.x, w.y)));
  std::array<double, 9> edges{};
  for (const int half : {0, 1})
    for (const int k : {0, 1, 2, 3})
      edges[4 * half + k] = half * kPi + (k > 0 ? kPi / 2 + (k - 2) * across : 0);
  edges[8] = 2 * kPi;
  const std::span<const double> round(edges);
  const Value sum =
      integrate_adaptively<Value>([&](double phi) { return ring(facing + phi); },
                                  turns ? round.first(5) : round, tolerance, area * least + 1e-300);
  return ((turns ? 1 : 0.5) / (kPi * area)) * sum;
}

/// The share of light from w, above a rough surface, that single scattering reflects to above.
/// weight(w . m, w_o), a double or an Rgb: the facet's reflectance, times the weight of rays along
/// w_o. kink, least: see above.
template <class Value, class Weight>
[[nodiscard]] Value reflected_share(const Facets& facets, Masking masking, Direction w,
                                    const Weight& weight, double tolerance = 1e-8, double kink = 0,
                                    double least = 0) {
  return average_over_facets<Value>(
      facets, w, SeenFacets::reflecting,
      [&](Direction wi, Direction m, double cosine) {
        Direction wo = 2 * cosine * m - wi;
        wo.z = std::fmax(wo.z, 0);
        return facets.passes(masking, false, wi, wo) * weight(cosine, wo);
      },
      tolerance, kink, least);
}

/// The share of light from w, above a rough dielectric of relative index `ratio` (below over
/// above), that single scattering refracts to below. weight(cosine): the weight of a ray below, in
/// [0, 1]. The tolerance is absolute.
template <class Weight>
[[nodiscard]] double refracted_share(const Facets& facets, Masking masking, double ratio,
                                     Direction w, const Weight& weight, double tolerance = 1e-8) {
  return average_over_facets<double>(
      facets, w, SeenFacets::all,
      [&](Direction wi, Direction m, double cosine) {
        const Refraction<double> r = refraction(cosine, ratio);
        if (!(r.cosine > 0)) return 0.0;
        const Direction wo = refracted_ray(wi, m, cosine, r.cosine, ratio);
        if (!(wo.z < 0)) return 0.0;
        return (1 - r.reflectance) * weight(-wo.z) *
               facets.passes(masking, true, wi, {wo.x, wo.y, -wo.z});
      },
      tolerance, critical_cosine(ratio), tolerance);
}

/// The share of light from w, above a rough surface, that single scattering loses: the facets' own
/// shadow and the rays that go to the wrong side. ratio: of a dielectric, or 0 for white mirrors.
/// Rounding of the single facets' losses leaves an absolute error of 1e-13.
[[nodiscard]] double lost_share(const Facets& facets, Masking masking, double ratio, Direction w,
                                double tolerance = 1e-8);

}  // namespace lamella
