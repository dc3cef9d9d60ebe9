#include "phase/interface/dielectric.h"

#include <cmath>

#include "phase/math/direction.h"
#include "phase/math/sampling.h"

namespace lamella {
namespace {

// The same direction above the surface.
Direction lifted(Direction w) { return {w.x, w.y, std::abs(w.z)}; }

// What a pair of directions finds at the one facet that takes light from w_i to w_o.
struct FacetPair {
  Direction m;      // unit, m.z >= 0, in the frame where w_i is above
  double cosine;    // w_i . m, > 0
  double share;     // Fresnel: reflected or refracted
  double jacobian;  // of m by w_o [sr/sr]
};

// wi above the surface; ratio: index below over above. share 0 where no facet does it.
FacetPair facet_between(Direction wi, Direction wo, double ratio) {
  FacetPair pair{{0, 0, 1}, 0, 0, 0};
  const bool reflects = wo.z > 0;
  Direction h = reflects ? wi + wo : -(wi + ratio * wo);
  const double size = length(h);
  if (!(size > 0)) return pair;
  h = (1 / size) * h;
  if (h.z < 0) h = -h;
  const double ci = dot(wi, h), co = dot(wo, h);
  if (!(ci > 0) || (reflects ? !(co > 0) : !(co < 0))) return pair;
  pair.m = h;
  pair.cosine = ci;
  const double reflectance = refraction(ci, ratio).reflectance;
  pair.share = reflects ? reflectance : 1 - reflectance;
  const double t = ci + ratio * co;
  pair.jacobian = reflects ? 1 / (4 * ci) : ratio * ratio * -co / (t * t);
  return pair;
}

}  // namespace

Direction Dielectric::smooth_refracted(Direction w, double cosine) const {
  const double inverse = 1 / ratio(w);
  const double x = -inverse * w.x, y = -inverse * w.y;
  const double z = w.z > 0 ? -cosine : cosine;
  return renormalized(Direction{x, y, z});
}

double Dielectric::single(Direction wi, Direction wo) const {
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const double n = ratio(wi);
  if (wi.z < 0) wi = -wi, wo = -wo;  // facets of both kinds are the same turned by pi about z
  const FacetPair pair = facet_between(wi, wo, n);
  if (pair.share == 0) return 0;
  return pair.share * facets.density(pair.m) * pair.cosine * pair.jacobian *
         facets.shadowing(masking, wo.z < 0, wi, lifted(wo));
}

double Dielectric::single_density(Direction wi, Direction wo) const {
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const double n = ratio(wi);
  if (wi.z < 0) wi = -wi, wo = -wo;
  const FacetPair pair = facet_between(wi, wo, n);
  if (pair.share == 0) return 0;
  return pair.share * facets.visible_density(wi, pair.m) * pair.jacobian;
}

Dielectric::Scattered Dielectric::scatter(Direction wi, RandomStream& stream) const {
  if (is_smooth()) {
    const Refraction<double> r = smooth_refraction(wi);
    if (r.cosine > 0 && stream.uniform() >= r.reflectance)
      return {smooth_refracted(wi, r.cosine), 1};
    return {{-wi.x, -wi.y, wi.z}, 1};
  }
  return multiple ? scatter_multiple(wi, stream) : scatter_single(wi, stream);
}

Dielectric::Scattered Dielectric::enter(Direction wi, RandomStream& stream) const {
  if (is_smooth()) {
    const Refraction<double> r = smooth_refraction(wi);
    if (r.cosine == 0) return {wi, 0};
    return {smooth_refracted(wi, r.cosine), 1 - r.reflectance};
  }
  if (multiple) {
    const Scattered s = scatter_multiple(wi, stream);
    return {s.wo, s.wo.z * wi.z < 0 ? 1.0 : 0.0};
  }
  const double n = ratio(wi);
  const bool from_below = wi.z < 0;
  if (from_below) wi = -wi;
  const double u1 = stream.uniform(), u2 = stream.uniform();
  const Direction m = facets.visible_normal(wi, u1, u2);
  const double cosine = dot(wi, m);
  const Refraction<double> r = refraction(nonnegative(cosine), n);
  const Direction wo = refracted_ray(wi, m, cosine, r.cosine, n);
  if (!(r.cosine > 0 && cosine > 0 && wo.z < 0)) return {wi, 0};
  return {from_below ? -wo : wo, (1 - r.reflectance) * facets.passes(masking, true, wi, lifted(wo))};
}

Dielectric::Scattered Dielectric::scatter_single(Direction wi, RandomStream& stream) const {
  const double n = ratio(wi);
  const bool from_below = wi.z < 0;
  if (from_below) wi = -wi;
  const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
  const Direction m = facets.visible_normal(wi, u1, u2);
  const double cosine = dot(wi, m);
  const Refraction<double> r = refraction(cosine, n);
  const bool refracts = r.cosine > 0 && u3 >= r.reflectance;
  Direction wo = refracts ? refracted_ray(wi, m, cosine, r.cosine, n) : mirrored(wi, m);
  double kept = 0;
  if (cosine > 0 && (refracts ? wo.z < 0 : wo.z > 0))
    kept = facets.passes(masking, refracts, wi, lifted(wo));
  if (from_below) wo = -wo;
  return {wo, kept};
}

// Meets a facet and flies on: true if the ray has left, along -ray.back on its side.
bool Dielectric::bounces_out(SmithRay& ray, RandomStream& stream) const {
  const double u1 = stream.uniform(), u2 = stream.uniform();
  const Direction m = facets.visible_normal(ray.back, u1, u2);
  const double cosine = dot(ray.back, m);
  const double n = ray.above ? below / above : above / below;
  const Refraction<double> r = refraction(nonnegative(cosine), n);
  if (r.cosine == 0 || stream.uniform() < r.reflectance)
    return ray.flies(facets, mirrored(ray.back, m), stream);
  const Direction through = refracted_ray(ray.back, m, cosine, r.cosine, n);
  ray.above = !ray.above;
  ray.s = SmithRay::other_side(ray.s);
  return ray.flies(facets, SmithRay::turned(through), stream);
}

Dielectric::Scattered Dielectric::scatter_multiple(Direction wi, RandomStream& stream) const {
  SmithRay ray = SmithRay::arriving(facets, wi, stream);
  while (!bounces_out(ray, stream)) {
  }
  return {ray.above ? -ray.back : SmithRay::turned(-ray.back), 1};
}

double Dielectric::multiple_estimate(Direction wi, Direction wo, RandomStream& stream) const {
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const bool to_above = wo.z > 0;
  const Direction target = lifted(wo);
  SmithRay ray = SmithRay::arriving(facets, wi, stream);
  double sum = 0;
  do {
    const double n = ray.above ? below / above : above / below;
    const bool stays = ray.above == to_above;
    const FacetPair pair = facet_between(ray.back, stays ? target : SmithRay::turned(target), n);
    if (pair.share == 0) continue;
    SmithRay leaving = ray;
    if (!stays) leaving.s = SmithRay::other_side(ray.s);
    sum += pair.share * facets.visible_density(ray.back, pair.m) * pair.jacobian *
           leaving.escapes(facets, target);
  } while (!bounces_out(ray, stream));
  return sum / target.z;
}

}  // namespace lamella
