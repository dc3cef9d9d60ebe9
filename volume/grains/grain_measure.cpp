#include "volume/grains/grain_measure.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "phase/math/sampling.h"
#include "phase/stack/stack_file.h"
#include "volume/grains/grain_scene.h"

namespace lamella {
namespace {

// Classes of cosines for the likelihood: fine enough that a fit does not see them.
constexpr int kFine = 400;
// Groups of realisations that are fitted apart for the error of a fit.
constexpr int kGroups = 16;
constexpr std::array<double, 3> kAreaCosines{1, 0.5, 0};

int bin_of(double cosine, int bins) {
  return std::clamp(static_cast<int>((cosine + 1) / 2 * bins), 0, bins - 1);
}
double centre_of(int bin, int bins) { return (bin + 0.5) / bins * 2 - 1; }

/// Counts of one realisation.
struct Counts {
  double grains = 0, points = 0, filled = 0, surface_points = 0, exposed = 0, rays = 0, passed = 0;
  std::array<double, 3> projected{};
  std::array<double, kNormalBins> normals{}, first{};
  std::array<double, kFine> normal_cosines{}, ray_cosines{};  // of first hits
  std::array<double, kProfileSlices> centres{}, slice_points{}, slice_filled{};
};

// Slices of the profile that lie within the bed, its lower spheres included.
int slices_of(const GrainGeometry& g) {
  const double depth = (kProfileTop * g.radius - g.bottom()) / (kProfileStep * g.radius);
  return std::min(kProfileSlices, static_cast<int>(depth + 1e-9));
}

void measure_profile(const GrainGeometry& g, const std::vector<Direction>& centres,
                     const GrainScene& scene, std::uint64_t points, RandomStream& stream,
                     Counts& counts) {
  const int slices = slices_of(g);
  const double top = kProfileTop * g.radius, step = kProfileStep * g.radius;
  for (const Direction& p : centres)
    if (const int k = static_cast<int>((top - p.z) / step); k < slices) ++counts.centres[k];
  for (std::uint64_t k = 0; k < points; ++k) {
    const double x = g.tile * stream.uniform(), y = g.tile * stream.uniform();
    const double at = slices * stream.uniform();
    const int slice = std::min(slices - 1, static_cast<int>(at));
    ++counts.slice_points[slice];
    counts.slice_filled[slice] += scene.is_inside({x, y, top - at * step});
  }
}

/// Ratio of two means over realisations with its standard error (delta method).
template <class Top, class Bottom>
Estimate ratio(const std::vector<Counts>& all, const Top& top, const Bottom& bottom) {
  double t = 0, b = 0;
  for (const Counts& c : all) {
    t += top(c);
    b += bottom(c);
  }
  if (b == 0) return {};
  const double value = t / b;
  double sum = 0;
  for (const Counts& c : all) {
    const double excess = top(c) - value * bottom(c);
    sum += excess * excess;
  }
  const double n = static_cast<double>(all.size());
  return {value, std::sqrt(sum * n / std::max(1.0, n - 1)) / std::abs(b)};
}

Counts measure_one(const GrainGeometry& g, std::uint64_t seed, std::uint64_t number,
                   std::uint64_t rays) {
  const auto centres = place_grains(g, seed, number);
  const GrainScene scene(g, centres);
  RandomStream stream(seed, number, StreamPurpose::measure);
  Counts counts;
  const double margin = std::min(
      g.thickness / 4, (g.placement == GrainPlacement::packed_sphere_bed ? 2 : 1) * g.radius);
  const auto is_within = [&](double z) { return z <= -margin && z >= -g.thickness + margin; };
  if (g.is_bed()) {
    std::vector<std::size_t> inner;
    for (std::size_t k = 0; k < centres.size(); ++k)
      if (is_within(centres[k].z)) inner.push_back(k);
    counts.grains = static_cast<double>(inner.size());
    for (std::uint64_t k = 0; k < rays; ++k) {
      const double x = g.tile * stream.uniform(), y = g.tile * stream.uniform();
      ++counts.points;
      counts.filled +=
          scene.is_inside({x, y, -margin - (g.thickness - 2 * margin) * stream.uniform()});
      if (inner.empty()) continue;
      const auto pick = static_cast<std::size_t>(stream.uniform() * counts.grains);
      const double u1 = stream.uniform(), u2 = stream.uniform();
      const Direction n = uniform_sphere(u1, u2);
      ++counts.surface_points;
      if (scene.is_inside(centres[inner[pick]] + g.radius * n)) continue;
      ++counts.exposed;
      ++counts.normals[bin_of(n.z, kNormalBins)];
      for (std::size_t j = 0; j < kAreaCosines.size(); ++j) {
        const double mu = kAreaCosines[j], s = std::sqrt(1 - mu * mu);
        counts.projected[j] += std::max(0.0, s * n.x + mu * n.z);
      }
    }
  }
  for (std::uint64_t k = 0; k < rays; ++k) {
    const double u1 = stream.uniform(), u2 = stream.uniform();
    Direction w = cosine_hemisphere(Direction{0, 0, 1}, u1, u2);
    const double x = g.tile * stream.uniform(), y = g.tile * stream.uniform();
    const GrainHit hit = scene.trace({x, y, g.top()}, -w);
    ++counts.rays;
    if (hit.end == RayEnd::down) ++counts.passed;
    if (hit.end != RayEnd::grain) continue;
    ++counts.first[bin_of(hit.normal.z, kNormalBins)];
    ++counts.normal_cosines[bin_of(hit.normal.z, kFine)];
    ++counts.ray_cosines[bin_of(w.z, kFine)];
  }
  if (g.is_bed()) measure_profile(g, centres, scene, rays, stream, counts);
  return counts;
}

/// Sums of the first hits of some realisations.
struct FirstHits {
  std::array<double, kFine> normals{}, rays{};

  void add(const Counts& c) {
    for (int k = 0; k < kFine; ++k) {
      normals[k] += c.normal_cosines[k];
      rays[k] += c.ray_cosines[k];
    }
  }
};

Direction direction_of(double cosine) {
  return {std::sqrt(std::max(0.0, 1 - cosine * cosine)), 0, cosine};
}

/// The parameter in [low, high] with the largest likelihood.
double fitted(const FirstHits& hits, double low, double high,
              const std::function<double(const FirstHits&, double)>& log_likelihood) {
  const auto [at, value] = boost::math::tools::brent_find_minima(
      [&](double x) { return -log_likelihood(hits, x); }, low, high, 26);
  return at;
}

double vmf_log_likelihood(const FirstHits& hits, double r) {
  const double alpha = vmf_alpha(r), kappa = vmf_concentration(alpha);
  const double log_norm = kappa > 0
                              ? std::log(kappa / (2 * kPi)) - std::log(-std::expm1(-2 * kappa))
                              : -std::log(4 * kPi);
  const Vmf ndf(alpha, {0, 0, 1});
  double sum = 0;
  for (int k = 0; k < kFine; ++k) {
    const double u = centre_of(k, kFine);
    if (hits.normals[k] > 0) sum += hits.normals[k] * (log_norm + kappa * (u - 1));
    if (hits.rays[k] > 0) sum -= hits.rays[k] * std::log(ndf.sigma(direction_of(u)));
  }
  return sum;
}

double sggx_log_likelihood(const FirstHits& hits, double alpha) {
  const Sggx ndf(Sggx::surface_matrix(alpha, {0, 0, 1}));
  double sum = 0;
  for (int k = 0; k < kFine; ++k) {
    const Direction w = direction_of(centre_of(k, kFine));
    if (hits.normals[k] > 0) sum += hits.normals[k] * std::log(ndf.density_of(w));
    if (hits.rays[k] > 0) sum -= hits.rays[k] * std::log(ndf.sigma(w));
  }
  return sum;
}

/// Shares of the normals that a distribution shows to the rays that met grains.
template <class Ndf>
std::array<double, kNormalBins> predicted(const Ndf& ndf, const FirstHits& hits) {
  std::array<double, kNormalBins> shares{};
  RandomStream stream(1, 0, StreamPurpose::measure);
  double total = 0;
  for (int k = 0; k < kFine; ++k) {
    if (hits.rays[k] == 0) continue;
    constexpr int kNormals = 500;
    total += hits.rays[k];
    for (int j = 0; j < kNormals; ++j) {
      const Direction m = ndf.visible_normal(direction_of(centre_of(k, kFine)), stream);
      shares[bin_of(m.z, kNormalBins)] += hits.rays[k] / kNormals;
    }
  }
  for (double& share : shares) share /= std::max(total, 1.0);
  return shares;
}

NormalFit fit(const std::vector<FirstHits>& groups, const FirstHits& all, double low, double high,
              const std::function<double(const FirstHits&, double)>& log_likelihood) {
  NormalFit result;
  result.roughness.value = fitted(all, low, high, log_likelihood);
  double sum = 0;
  for (const FirstHits& group : groups) {
    const double excess = fitted(group, low, high, log_likelihood) - result.roughness.value;
    sum += excess * excess;
  }
  const double n = static_cast<double>(groups.size());
  result.roughness.standard_error = std::sqrt(sum / n / std::max(1.0, n - 1));
  return result;
}

}  // namespace

GrainMeasurement measure_grains(const GrainGeometry& in_mm, std::uint64_t seed,
                                std::uint64_t realisations, std::uint64_t rays) {
  GrainScene::require_available();
  const GrainGeometry g = in_mm.in_units();
  const double unit = in_mm.length_unit();
  std::vector<Counts> all(realisations);
  tbb::parallel_for(std::uint64_t{0}, realisations,
                    [&](std::uint64_t k) { all[k] = measure_one(g, seed, k, rays); });
  GrainMeasurement m;
  m.realisations = realisations;
  m.rays = realisations * rays;
  if (g.is_bed()) {
    m.filled = ratio(
        all, [](const Counts& c) { return c.filled; }, [](const Counts& c) { return c.points; });
    m.exposed = ratio(
        all, [](const Counts& c) { return c.exposed; },
        [](const Counts& c) { return c.surface_points; });
    // Surface of the grains whose centres lie within, over the empty volume there.
    const double margin = std::min(
        g.thickness / 4, (g.placement == GrainPlacement::packed_sphere_bed ? 2 : 1) * g.radius);
    const double volume = g.tile * g.tile * (g.thickness - 2 * margin);
    const double sphere = 4 * kPi * g.radius * g.radius;
    const auto per_point = [&](const Counts& c, double sum) {
      return c.surface_points > 0 ? c.grains * sphere * sum / c.surface_points : 0.0;
    };
    const auto empty = [&](const Counts& c) { return volume * (1 - c.filled / c.points); };
    const auto per_mm = [&](Estimate e) {
      return Estimate{e.value / unit, e.standard_error / unit};
    };
    m.surface_area = per_mm(ratio(
        all, [&](const Counts& c) { return per_point(c, c.exposed); }, empty));
    for (std::size_t j = 0; j < kAreaCosines.size(); ++j)
      m.projected_area[j] = per_mm(ratio(
          all, [&](const Counts& c) { return per_point(c, c.projected[j]); }, empty));
    const double slice_volume = g.tile * g.tile * kProfileStep * g.radius;
    for (int k = 0; k < slices_of(g); ++k) {
      const double z = (kProfileTop - k * kProfileStep) * g.radius;
      m.profile.push_back(
          {.z_from = unit * z,
           .z_to = unit * (z - kProfileStep * g.radius),
           .packing = ratio(
               all, [&](const Counts& c) { return c.centres[k] * sphere * g.radius / 3; },
               [&](const Counts&) { return slice_volume; }),
           .filled = ratio(
               all, [&](const Counts& c) { return c.slice_filled[k]; },
               [&](const Counts& c) { return c.slice_points[k]; })});
    }
    m.extinction = {m.surface_area.value / 4, m.surface_area.standard_error / 4};
    for (int k = 0; k < kNormalBins; ++k)
      m.normals[k] = ratio(
          all, [&](const Counts& c) { return c.normals[k]; },
          [](const Counts& c) { return c.exposed; });
  }
  m.passed = ratio(
      all, [](const Counts& c) { return c.passed; }, [](const Counts& c) { return c.rays; });
  std::vector<FirstHits> groups(std::min<std::size_t>(kGroups, all.size()));
  FirstHits sum;
  double hits = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    groups[k % groups.size()].add(all[k]);
    sum.add(all[k]);
    for (const double n : all[k].first) hits += n;
  }
  for (int k = 0; k < kNormalBins; ++k)
    m.first_normals[k] = ratio(
        all, [&](const Counts& c) { return c.first[k]; },
        [](const Counts& c) {
          double n = 0;
          for (const double f : c.first) n += f;
          return n;
        });
  if (hits == 0) return m;
  m.vmf = fit(groups, sum, 0.002, 1, vmf_log_likelihood);
  m.vmf.first_normals = predicted(Vmf(vmf_alpha(m.vmf.roughness.value), {0, 0, 1}), sum);
  m.sggx = fit(groups, sum, 0.01, 1, sggx_log_likelihood);
  m.sggx.first_normals =
      predicted(Sggx(Sggx::surface_matrix(m.sggx.roughness.value, {0, 0, 1})), sum);
  return m;
}

Stack equivalent_stack(const Stack& stack, const GrainMeasurement& m, Equivalent medium) {
  const GrainGeometry* g = stack.grains();
  if (!g) throw std::invalid_argument("a stack of media needs no equivalent");
  const bool lambert = g->surface == GrainSurface::lambert;
  if (g->surface == GrainSurface::dielectric)
    throw std::invalid_argument("no medium stands for dielectric grains");
  if (medium == Equivalent::lambert_sphere && !(lambert && g->is_bed()))
    throw std::invalid_argument("Lambert spheres stand for Lambertian sphere beds only");
  std::string keys;
  if (medium == Equivalent::lambert_sphere)
    keys = "medium = \"lambert_sphere\"\n";
  else if (medium == Equivalent::vmf_flake)
    keys = fmt::format("medium = \"vmf_flake\"\nroughness = {}\n", m.vmf.roughness.value);
  else
    keys = fmt::format("medium = \"sggx\"\nroughness = {}\n", m.sggx.roughness.value);
  if (medium != Equivalent::lambert_sphere) {
    keys += lambert ? "flake = \"lambert\"\n" : "flake = \"mirror\"\n";
    if (!lambert) keys += fmt::format("f0 = {}\n", to_text(stack.layers[0].f0));
  }
  keys += fmt::format("albedo = {}\n", to_text(stack.layers[0].albedo));
  // The density follows from sigma, which the reader's medium knows.
  Stack unit = parse_stack("[[layer]]\n" + keys + "thickness = 1\n", "equivalent", stack.name);
  const Medium& made = unit.layers[0].medium;
  double density = 0;
  if (g->is_bed()) {
    // sigma along directions from above with the density cos / pi, by the midpoint rule in mu^2.
    constexpr int kSteps = 2000;
    double mean = 0;
    for (int k = 0; k < kSteps; ++k)
      mean += sigma(made, direction_of(std::sqrt((k + 0.5) / kSteps))) / kSteps;
    density = m.extinction.value / mean;
  } else {
    density = -std::log1p(-g->tau0) / (sigma(made, {0, 0, 1}) * g->thickness);
  }
  unit.name = stack.name + "-equivalent";
  unit.layers[0].density = density;
  const bool thick = g->is_bed() && !stack.substrate && m.passed.value < 1e-3;
  unit.layers[0].thickness = thick ? std::numeric_limits<double>::infinity() : g->thickness;
  unit.substrate = stack.substrate;
  return unit;
}

}  // namespace lamella
