#include "compare/bench/textbook_coat.h"

#include "compare/bench/textbook_parts.h"

namespace lamella {
namespace {

using namespace textbook;

// GGX facets of one alpha; directions on the side of the facets' normals.
struct Ggx {
  double alpha;

  double lambda(Direction w) const {
    const double c2 = w.z * w.z;
    return 0.5 * (std::sqrt(1 + alpha * alpha * (1 - c2) / c2) - 1);
  }
  Direction visible_normal(Direction wi, auto& rng) const {
    const Direction v = normalized(Direction{alpha * wi.x, alpha * wi.y, wi.z});
    const double across = v.x * v.x + v.y * v.y;
    const double inverse = across > 0 ? 1 / std::sqrt(across) : 0;
    const Direction t1 =
        across > 0 ? Direction{-v.y * inverse, v.x * inverse, 0} : Direction{1, 0, 0};
    const Direction t2 = cross(v, t1);
    const double r = std::sqrt(rng.uniform()), phi = 2 * kPi * rng.uniform();
    const double x = r * std::cos(phi), s = 0.5 * (1 + v.z);
    const double y = (1 - s) * std::sqrt(1 - x * x) + s * r * std::sin(phi);
    const double z = std::sqrt(std::max(0.0, 1 - x * x - y * y));
    const Direction n = x * t1 + y * t2 + z * v;
    return normalized(Direction{alpha * n.x, alpha * n.y, std::max(0.0, n.z)});
  }
};

// Light at the coat: `back` points to where it comes from, and then to where it came from as it
// flies on. False where it is lost to the wrong side.
bool cross_coat(const Ggx& facets, double ior, Direction& back, double& weight, auto& rng) {
  const bool inside = back.z < 0;
  const Direction wi = inside ? -back : back;
  const double eta = inside ? 1 / ior : ior;
  const Direction m = facets.visible_normal(wi, rng);
  const double c = dot(wi, m);
  const double sine2 = (1 - c * c) / (eta * eta);
  double reflectance = 1, refracted = 0;
  if (sine2 < 1) {
    refracted = std::sqrt(1 - sine2);
    const double s = (c - eta * refracted) / (c + eta * refracted);
    const double p = (eta * c - refracted) / (eta * c + refracted);
    reflectance = 0.5 * (s * s + p * p);
  }
  const bool reflects = rng.uniform() < reflectance;
  const Direction wo = reflects ? 2 * c * m - wi : (c / eta - refracted) * m - (1 / eta) * wi;
  if ((wo.z > 0) != reflects) return false;
  const double li = facets.lambda(wi), lo = facets.lambda(wo);
  weight *= (1 + li) / (1 + li + lo);
  back = inside ? wo : -wo;
  return true;
}

// An event: false where roulette ends the walk.
bool survives(int events, double albedo, double& weight, auto& rng) {
  if (events > 3) return rng.uniform() < albedo;
  weight *= albedo;
  return true;
}

}  // namespace

TextbookCoat::TextbookCoat(const TextbookCoatCase& what, Direction wi, std::uint64_t seed)
    : case_(what), wi_(wi), state_(seed * 0x9E3779B97F4A7C15ULL), increment_(2 * seed + 1) {
  result_.f.resize(kMuCells * kPhiCells);
}

void TextbookCoat::advance(std::uint64_t walks) {
  Pcg32 rng{state_, increment_};
  const Ggx facets{case_.alpha};
  const double ior = case_.ior, albedo = case_.albedo;
  std::uint64_t all_events = 0, meetings = 0;
  double reflected = 0, reflected2 = 0, coat = 0;
  for (std::uint64_t walk = 0; walk < walks; ++walk) {
    Direction back = wi_;
    double weight = 1;
    int events = 0;
    bool alive = true;
    for (;;) {
      ++meetings;
      alive = cross_coat(facets, ior, back, weight, rng);
      if (!alive || back.z < 0) break;  // lost, or out
      if (!case_.spheres) {
        ++events;
        alive = survives(events, albedo, weight, rng);
        if (!alive) break;
        back = -cosine_law({0, 0, 1}, rng);
        continue;
      }
      double y = 0;
      for (;;) {
        y += -std::log(rng.uniform()) * back.z;
        if (y < 0) break;
        ++events;
        alive = survives(events, albedo, weight, rng);
        if (!alive) break;
        back = -from_lambert_sphere(back, rng);
      }
      if (!alive) break;
    }
    all_events += static_cast<std::uint64_t>(events);
    if (!alive) continue;
    reflected += weight;
    reflected2 += weight * weight;
    if (events == 0) coat += weight;
    result_.f[cell_of(back)] += weight * kCellsPerSteradian;
  }
  result_.walks += walks;
  result_.events += all_events;
  result_.meetings += meetings;
  result_.reflected += reflected;
  result_.reflected2 += reflected2;
  result_.coat += coat;
  state_ = rng.state;
}

}  // namespace lamella
