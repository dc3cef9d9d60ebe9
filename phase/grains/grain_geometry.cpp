#include "phase/grains/grain_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

// Number of grains in a tile, and the smallest tile in radii, unless the file gives the tile: of
// this many grains a path meets about one twice because of the period.
constexpr double kUsualGrains = 20000, kUsualTile = 40;
// Trials in a row after which a packing counts as out of reach.
constexpr int kTrials = 200000;

double sphere_volume(double radius) { return 4 * kPi / 3 * radius * radius * radius; }

/// The spheres that stand so far, found by the cell of a grid they lie in: cells of an edge of at
/// least a diameter, so that only neighbours can overlap. Periodic in x and y, and in z where the
/// bed is cut.
class Packing {
 public:
  explicit Packing(const GrainGeometry& g)
      : g_(g),
        nx_(std::max(1, static_cast<int>(g.tile / (2 * g.radius)))),
        nz_(std::max(1, static_cast<int>(g.packed_height() / (2 * g.radius)))),
        cells_(static_cast<std::size_t>(nx_) * nx_ * nz_) {}

  [[nodiscard]] bool has_room_for(Direction p) const {
    const int x = lateral(p.x), y = lateral(p.y), z = level(p.z);
    // A grid of fewer than three cells would name a neighbour twice: harmless.
    const int from = g_.cut ? z - 1 : std::max(0, z - 1);
    const int to = g_.cut ? z + 1 : std::min(nz_ - 1, z + 1);
    for (int k = from; k <= to; ++k)
      for (int j = y - 1; j <= y + 1; ++j)
        for (int i = x - 1; i <= x + 1; ++i)
          for (const Direction& q :
               cells_[index((i + nx_) % nx_, (j + nx_) % nx_, (k + nz_) % nz_)])
            if (overlap(p, q)) return false;
    return true;
  }
  void add(Direction p) { cells_[index(lateral(p.x), lateral(p.y), level(p.z))].push_back(p); }

 private:
  [[nodiscard]] int lateral(double x) const {
    return std::min(nx_ - 1, static_cast<int>(x / g_.tile * nx_));
  }
  [[nodiscard]] int level(double z) const {
    const double height = g_.packed_height();
    return height > 0 ? std::min(nz_ - 1, static_cast<int>(-z / height * nz_)) : 0;
  }
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * nx_ + y) * nx_ + x;
  }
  [[nodiscard]] bool overlap(Direction p, Direction q) const {
    Direction d = p - q;
    d.x -= g_.tile * std::round(d.x / g_.tile);
    d.y -= g_.tile * std::round(d.y / g_.tile);
    if (g_.cut) d.z -= g_.packed_height() * std::round(d.z / g_.packed_height());
    return dot(d, d) < 4 * g_.radius * g_.radius;
  }

  const GrainGeometry& g_;
  int nx_, nz_;
  std::vector<std::vector<Direction>> cells_;
};

std::vector<Direction> packed(const GrainGeometry& g, RandomStream& stream) {
  const double height = g.packed_height();
  const double expected =
      g.cut ? g.number_density() * g.tile * g.tile * height : g.expected_count();
  const auto count = static_cast<std::size_t>(expected + stream.uniform());
  std::vector<Direction> centres;
  centres.reserve(count);
  Packing packing(g);
  while (centres.size() < count) {
    int trial = 0;
    Direction p{};
    do {
      if (trial++ == kTrials)
        throw PackingError(g.packing, g.packing * static_cast<double>(centres.size()) /
                                          static_cast<double>(count));
      p = {g.tile * stream.uniform(), g.tile * stream.uniform(), -height * stream.uniform()};
    } while (!packing.has_room_for(p));
    packing.add(p);
    centres.push_back(p);
  }
  // Every height of a periodic box is like every other.
  if (g.cut) std::erase_if(centres, [&](Direction p) { return p.z < -g.thickness; });
  return centres;
}

/// A Poisson process: exponential steps along one axis, uniform across it.
std::vector<Direction> scattered(const GrainGeometry& g, RandomStream& stream) {
  std::vector<Direction> centres;
  const double expected = g.expected_count();
  centres.reserve(static_cast<std::size_t>(expected + 4 * std::sqrt(expected)));
  // Along the axis in units of its length: the step is 1 / expected in the mean.
  for (double at = stream.exponential(); at < expected; at += stream.exponential()) {
    const double along = at / expected, u = stream.uniform();
    if (g.is_bed())
      centres.push_back({g.tile * u, g.tile * stream.uniform(), -g.thickness * along});
    else
      centres.push_back({g.tile * along, g.tile * u, 0});
  }
  return centres;
}

ParameterInfo number(std::string name, std::string unit, std::string doc, double min, double max,
                     std::string default_value = {}) {
  return {.name = std::move(name),
          .unit = std::move(unit),
          .doc = std::move(doc),
          .default_value = std::move(default_value),
          .min = min,
          .max = max,
          .min_open = true,
          .max_open = true};
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ParameterInfo surface(std::vector<std::string> choices) {
  return {.name = "surface",
          .kind = ParameterKind::choice,
          .unit = "1",
          .doc = "of a grain",
          .default_value = "lambert",
          .choices = std::move(choices)};
}

ParameterInfo f0() {
  return {.name = "f0",
          .kind = ParameterKind::color,
          .unit = "1",
          .doc = "Schlick's reflectance at normal incidence of mirrors and conductors (default 1)",
          .min = 0,
          .max = 1};
}

ParameterInfo tile() {
  return number("tile", "mm", "lateral period (default: wide enough not to matter)", 0, kInfinity);
}

std::vector<ParameterInfo> bed_parameters(ParameterInfo packing) {
  return {number("radius", "mm", "of the spheres", 0, kInfinity),
          std::move(packing),
          number("thickness", "mm", "centres lie in [-thickness, 0]", 0, kInfinity),
          surface({"lambert", "mirror"}),
          f0(),
          tile()};
}

std::vector<ParameterInfo> packed_parameters() {
  auto list = bed_parameters(
      number("packing", "1", "number density times the volume of a sphere", 0, 0.384));
  list.push_back({.name = "cut",
                  .kind = ParameterKind::choice,
                  .unit = "1",
                  .doc = "true: the bed is cut from a larger packing, as dense at its surface as "
                         "inside; false (default): centres crowd at its two ends",
                  .choices = {"false", "true"}});
  return list;
}

std::vector<ParameterInfo> height_field_parameters() {
  return {{.name = "roughness",
           .unit = "1",
           .doc = "alpha of Beckmann's slopes: twice the standard deviation of the heights over "
                  "the correlation length",
           .min = 0.001,
           .max = 4},
          number("correlation", "mm", "length of the heights' autocorrelation", 0, kInfinity, "1"),
          {.name = "resolution",
           .unit = "1",
           .doc = "nodes per correlation length; triangles lie between them",
           .default_value = "8",
           .min = 2,
           .max = 64},
          surface({"lambert", "mirror", "dielectric"}),
          f0(),
          number("ior", "1", "index of refraction of a dielectric (default 1.5)", 1, kInfinity),
          number("tile", "mm", "lateral period (default: 32 correlation lengths)", 0, kInfinity)};
}

// Of the heights, in the shortest tile and by default in correlation lengths.
constexpr double kShortestField = 8, kUsualField = 32;
// Standard deviations above the mean where light comes from: beyond all heights.
constexpr double kHighest = 8;

void make_height_field(GrainGeometry& g, const GeometryInfo& info, Parameters& p) {
  if (!p.has("roughness"))
    throw ParameterError("roughness", "nothing",
                         allowed_values(*find(info.parameters, "roughness")));
  g.alpha = p.number("roughness");
  g.radius = p.number("correlation");
  g.thickness = 2 * kHighest * g.alpha * g.radius / 2;
  if (!p.has("tile")) p.set("tile", kUsualField * g.radius);
  g.tile = p.number("tile");
  const double per_length = p.number("resolution"), lengths = g.tile / g.radius;
  const double triangles = 2 * (lengths * per_length) * (lengths * per_length);
  if (!(lengths >= kShortestField) || !(triangles <= kMostGrains))
    throw ParameterError(
        "tile", to_text(g.tile),
        fmt::format("a number in [{}, {}]: {:g} correlation lengths or more, and no more than {:g} "
                    "triangles at this resolution",
                    to_text(kShortestField * g.radius),
                    to_text(std::sqrt(kMostGrains / 2) / per_length * g.radius), kShortestField,
                    kMostGrains));
  g.nodes = static_cast<int>(std::lround(lengths * per_length));
}

}  // namespace

GrainSurface grain_surface_from(std::string_view name) {
  return name == "mirror"       ? GrainSurface::mirror
         : name == "dielectric" ? GrainSurface::dielectric
         : name == "conductor"  ? GrainSurface::conductor
                                : GrainSurface::lambert;
}

double GrainGeometry::number_density() const {
  if (is_height_field()) return 2 * (nodes / tile) * (nodes / tile);
  return is_bed() ? packing / sphere_volume(radius) : -std::log1p(-tau0) / (kPi * radius * radius);
}

double GrainGeometry::expected_count() const {
  const GrainGeometry g = in_units();
  return g.number_density() * g.tile * g.tile * (is_bed() ? g.thickness : 1);
}

double GrainGeometry::length_unit() const { return std::ldexp(1.0, std::ilogb(radius)); }

GrainGeometry GrainGeometry::in_units() const {
  GrainGeometry g = *this;
  const double unit = length_unit();
  for (double* length : {&g.radius, &g.thickness, &g.tile}) *length /= unit;
  return g;
}

PackingError::PackingError(double asked, double reached)
    : std::runtime_error(fmt::format(
          "packed_sphere_bed: packing {:g} is out of reach: {:.4f} stood when {} trials in a row "
          "found no room; allowed: less (random sequential addition ends near 0.38)",
          asked, reached, kTrials)) {}

std::vector<Direction> place_grains(const GrainGeometry& geometry, std::uint64_t seed,
                                    std::uint64_t realisation) {
  RandomStream stream(seed, realisation, StreamPurpose::geometry);
  const GrainGeometry g = geometry.in_units();
  std::vector<Direction> centres =
      g.placement == GrainPlacement::packed_sphere_bed ? packed(g, stream) : scattered(g, stream);
  if (const double unit = geometry.length_unit(); unit != 1)
    for (Direction& p : centres) p = unit * p;
  return centres;
}

const std::vector<GeometryInfo>& geometries() {
  static const std::vector<GeometryInfo> list{
      {.name = "sphere_bed",
       .placement = GrainPlacement::sphere_bed,
       .doc = "equal spheres whose centres are a Poisson process, overlapping where they will",
       .source = "d'Eon 2021, Lambert-sphere BRDF, figure 1; d'Eon and Weidlich 2024, VMF Diffuse, "
                 "figures 2, 5, 6",
       .parameters = bed_parameters(
           number("packing", "1",
                  "number density times the volume of a sphere; the spheres fill 1 - exp(-packing)",
                  0, kInfinity))},
      {.name = "packed_sphere_bed",
       .placement = GrainPlacement::packed_sphere_bed,
       .doc = "equal spheres that do not overlap, by random sequential addition; denser at its two "
              "ends "
              "unless cut = true",
       .source = "Torquato 2002, Random Heterogeneous Materials",
       .parameters = packed_parameters()},
      {.name = "micrograins",
       .placement = GrainPlacement::micrograins,
       .doc = "half ellipsoids on the substrate (black if there is none), their centres a Poisson "
              "process",
       .source = "Lucas et al. 2023, A Micrograin BSDF Model for the Rendering of Porous Layers",
       .parameters = {{.name = "tau0",
                       .unit = "1",
                       .doc = "filling factor: share of the plane under grains",
                       .min = 0,
                       .max = 1,
                       .max_open = true},
                      {.name = "beta",
                       .unit = "1",
                       .doc = "anfractuosity: height of a grain over its radius",
                       .min = 0.001,
                       .max = 1},
                      number("radius", "mm", "horizontal, of a grain", 0, kInfinity, "1"),
                      surface({"lambert", "dielectric", "conductor"}),
                      f0(),
                      number("ior", "1", "index of refraction of dielectric grains (default 1.5)",
                             1, kInfinity),
                      tile()}},
      {.name = "height_field",
       .placement = GrainPlacement::height_field,
       .doc = "opaque random surface, heights Gaussian with the autocorrelation exp(-r^2 / "
              "correlation^2): Beckmann's slopes, and heights that neighbours share",
       .source = "Beckmann and Spizzichino 1963; Heitz et al. 2016, of whose stochastic surface it "
                 "is the real one",
       .parameters = height_field_parameters()}};
  return list;
}

const GeometryInfo* find_geometry(std::string_view name) {
  const auto& list = geometries();
  const auto it = std::find_if(list.begin(), list.end(),
                               [&](const GeometryInfo& info) { return info.name == name; });
  return it == list.end() ? nullptr : &*it;
}

GrainGeometry make_geometry(const GeometryInfo& info, Parameters& p) {
  const auto needed = [&](const char* key) {
    if (!p.has(key))
      throw ParameterError(key, "nothing", allowed_values(*find(info.parameters, key)));
    return p.number(key);
  };
  GrainGeometry g;
  g.placement = info.placement;
  if (g.is_height_field()) {
    make_height_field(g, info, p);
  } else if (g.is_bed()) {
    g.radius = needed("radius");
    g.packing = needed("packing");
    g.cut = p.has("cut") && p.choice("cut") == "true";
    g.thickness = needed("thickness");
  } else {
    g.radius = needed("radius");
    g.tau0 = needed("tau0");
    g.beta = needed("beta");
    g.thickness = g.beta * g.radius;
  }
  g.surface = grain_surface_from(p.choice("surface"));
  if (g.surface == GrainSurface::mirror || g.surface == GrainSurface::conductor) {
    if (!p.has("f0")) p.set("f0", Rgb(1));
  } else if (p.has("f0")) {
    throw ParameterError("f0", to_text(p.at("f0")), "nothing: only mirrors and conductors have f0");
  }
  if (g.surface == GrainSurface::dielectric) {
    if (!p.has("ior")) p.set("ior", 1.5);
    g.ior = p.number("ior");
  } else if (p.has("ior")) {
    throw ParameterError("ior", to_text(p.at("ior")), "nothing: only dielectrics have ior");
  }
  if (g.is_height_field()) return g;
  if (p.has("tile")) {
    g.tile = p.number("tile");
    if (g.tile < 4 * g.radius)
      throw ParameterError(
          "tile", to_text(g.tile),
          fmt::format("a number in [{}, inf), four radii or more", to_text(4 * g.radius)));
  } else {
    g.tile = g.length_unit();
    const double one = g.expected_count();
    const double usual = std::sqrt(kUsualGrains / one) * g.length_unit();
    g.tile = kUsualTile * g.radius;
    if (g.is_bed()) g.tile = std::max(g.tile, usual);
    p.set("tile", g.tile);
  }
  const double most = g.expected_count() * (g.packed_height() / g.thickness);
  if (g.is_bed() ? !(most <= kMostGrains) : !(g.expected_count() <= kMostGrains))
    throw ParameterError(
        "tile", to_text(g.tile),
        fmt::format("one with {:g} grains at most: {:.3g} stand in it (tile, thickness or packing "
                    "are too large, or the radius is too small)",
                    kMostGrains, g.is_bed() ? most : g.expected_count()));
  return g;
}

}  // namespace lamella
