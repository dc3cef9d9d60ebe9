#include "phase/surface/conductor.h"

#include <cmath>

#include "phase/math/direction.h"
#include "phase/math/sampling.h"
#include "phase/surface/fresnel_formulas.h"
#include "phase/surface/smith_walk.h"

namespace lamella {

Rgb Conductor::reflectance(double cosine) const {
  const Setting& s = setting_;
  if (s.white) return Rgb(1);
  Rgb f;
  for (int c = 0; c < 3; ++c)
    f[c] = c > 0 && s.eta[c] == s.eta[c - 1] && s.k[c] == s.k[c - 1]
               ? f[c - 1]
               : conductor_reflectance(cosine, s.eta[c], s.k[c]);
  return f;
}

Rgb Conductor::single(Direction wi, Direction wo) const {
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const Direction h = normalized(wi + wo);
  return (setting_.facets.density(h) * setting_.facets.shadowing(setting_.masking, false, wi, wo) /
          4) *
         reflectance(nonnegative(dot(wi, h)));
}

double Conductor::single_density(Direction wi, Direction wo) const {
  const Direction h = normalized(with_grazing_limit(wi) + wo);
  const double cosine = dot(wi, h);
  return cosine > 0 ? setting_.facets.visible_density(with_grazing_limit(wi), h) / (4 * cosine) : 0;
}

Rgb Conductor::eval(Direction wi, Direction wo, RandomStream& stream) const {
  return setting_.multiple ? multiple_estimate(wi, wo, stream) : single(wi, wo);
}

std::optional<SurfaceLaw::Sample> Conductor::sample(Direction wi, RandomStream& stream) const {
  if (is_delta()) return Sample{{-wi.x, -wi.y, wi.z}, reflectance(wi.z)};
  wi = with_grazing_limit(wi);
  if (setting_.multiple) return sample_multiple(wi, stream);
  const double u1 = stream.uniform(), u2 = stream.uniform();
  const Direction m = setting_.facets.visible_normal(wi, u1, u2);
  const Direction wo = mirrored(wi, m);
  const Rgb reflected = reflectance(nonnegative(dot(wi, m)));
  const double passes = wo.z > 0 ? setting_.facets.passes(setting_.masking, false, wi, wo) : 0;
  return Sample{wo, passes * reflected, (1 - passes) * reflected};
}

SurfaceLaw::Sample Conductor::sample_multiple(Direction wi, RandomStream& stream) const {
  SmithRay ray = SmithRay::arriving(setting_.facets, wi, stream);
  Rgb weight(1);
  for (;;) {
    const double u1 = stream.uniform(), u2 = stream.uniform();
    const Direction m = setting_.facets.visible_normal(ray.back, u1, u2);
    weight = weight * reflectance(nonnegative(dot(ray.back, m)));
    if (ray.flies(setting_.facets, mirrored(ray.back, m), stream)) return {-ray.back, weight};
  }
}

Rgb Conductor::multiple_estimate(Direction wi, Direction wo, RandomStream& stream) const {
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const Facets& facets = setting_.facets;
  SmithRay ray = SmithRay::arriving(facets, wi, stream);
  Rgb weight(1), sum;
  for (;;) {
    const Direction h = normalized(ray.back + wo);
    const double cosine = dot(ray.back, h);
    if (h.z > 0 && cosine > 0)
      sum += (facets.visible_density(ray.back, h) / (4 * cosine) * ray.escapes(facets, wo)) *
             (weight * reflectance(cosine));
    const double u1 = stream.uniform(), u2 = stream.uniform();
    const Direction m = facets.visible_normal(ray.back, u1, u2);
    weight = weight * reflectance(nonnegative(dot(ray.back, m)));
    if (ray.flies(facets, mirrored(ray.back, m), stream)) return (1 / wo.z) * sum;
  }
}

}  // namespace lamella
