#include "volume/voxels/grid_generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "phase/math/direction.h"
#include "volume/voxels/gradient_noise.h"

namespace lamella {
namespace {

constexpr const char* kBuiltin = "builtin:";

ParameterInfo length(std::string name, std::string doc, std::string value) {
  return {.name = std::move(name),
          .unit = "mm",
          .doc = std::move(doc),
          .default_value = std::move(value),
          .min = 1e-6,
          .max = 1e6};
}

ParameterInfo count(std::string name, std::string doc, std::string value, double min, double max) {
  return {.name = std::move(name),
          .unit = "1",
          .doc = std::move(doc),
          .default_value = std::move(value),
          .min = min,
          .max = max};
}

ParameterInfo color(std::string name, std::string doc) {
  return {.name = std::move(name),
          .kind = ParameterKind::color,
          .unit = "1",
          .doc = std::move(doc),
          .default_value = "1",
          .min = 0,
          .max = 1};
}

ParameterInfo contrast(std::string doc, std::string value) {
  return {.name = "contrast",
          .unit = "1",
          .doc = std::move(doc),
          .default_value = std::move(value),
          .min = 0,
          .max = 10};
}

int whole(const Parameters& p, const std::string& name) {
  const double value = p.number(name);
  if (value != std::floor(value)) throw ParameterError(name, to_text(value), "a whole number");
  return static_cast<int>(value);
}

// Voxels along a length of which `across` would take n.
int voxels_along(double length, double across, int n) {
  constexpr int kMost = 4096;
  return std::clamp(static_cast<int>(std::lround(n * length / across)), 1, kMost);
}

// ---- weave

GeneratedGrid make_weave(const Parameters& p) {
  const double pitch = p.number("pitch"), width = p.number("width"), height = p.number("height");
  const double twist = p.number("twist");
  const int n = whole(p, "voxels");
  if (width > pitch) throw ParameterError("width", to_text(width), "at most the pitch");
  // Two yarns each way until the pattern repeats; they cross above and below each other.
  const double size = 2 * pitch, thickness = 2 * height;
  const int nz = voxels_along(thickness, size, n);
  Voxels voxels(VoxelExtent{{n, n, nz}});
  voxels.orientation.emplace(voxels.extent());
  const Rgb warp = p.color("warp"), weft = p.color("weft");
  const bool colored = warp != Rgb(1) || weft != Rgb(1);
  if (colored) {
    voxels.albedo.emplace(voxels.extent());
    voxels.albedo->fill({0, 0, 0}, voxels.extent().voxels, {1, 1, 1});
  }
  const double amplitude = height / 2, a = width / 2, b = height / 2;
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    const double place[2] = {(i[0] + 0.5) / n * size, (i[1] + 0.5) / n * size};
    const double z = (i[2] + 0.5) / nz * thickness - thickness / 2;
    double best = 0;
    for (int way = 0; way < 2; ++way) {  // 0: weft, along x; 1: warp, along y
      const double along = place[way], across = place[1 - way];
      const int yarn = std::min(1, static_cast<int>(across / pitch));
      const double phase = kPi * (along / pitch - 0.5);
      const double sign = ((yarn + way) % 2 == 0 ? 1 : -1);
      const double middle = sign * amplitude * std::cos(phase);
      const double slope = -sign * amplitude * kPi / pitch * std::sin(phase);
      const double s = across - (yarn + 0.5) * pitch, t = z - middle;
      const double r2 = (s / a) * (s / a) + (t / b) * (t / b);
      if (r2 >= 1) continue;
      // Densest in the core; where yarns touch, the denser one holds the voxel.
      const double density = 1 - 0.5 * r2;
      if (density <= best) continue;
      best = density;
      // The core's tangent, and about it the fibers' turn, faster the farther out.
      const double turn = 2 * kPi * twist;
      const double d[3] = {1, -turn * t, turn * s};  // along, across, up
      Direction v{0, 0, slope * d[0] + d[2]};
      (way == 0 ? v.x : v.y) = d[0];
      (way == 0 ? v.y : v.x) = d[1];
      v = normalized(v);
      voxels.orientation->set(
          i, {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
      if (colored) {
        const Rgb c = way == 0 ? weft : warp;
        voxels.albedo->set(
            i, {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)});
      }
    }
    if (best > 0) voxels.density.set(i, {static_cast<float>(best)});
  });
  return {std::move(voxels), size, size, thickness,
          "medium = \"sggx\"\nshape = \"fiber\"\nroughness = 0.3\nalbedo = 0.9\ndensity = 12\n"};
}

// ---- noise

// Several octaves of gradient noise over a tile, each with half the size and half the height.
class Octaves {
 public:
  Octaves(double size, double depth, double feature, int octaves, std::uint64_t seed) {
    for (int k = 0; k < octaves; ++k) {
      const double cell = feature / (1 << k);
      const int lateral = std::max(1, static_cast<int>(std::lround(size / cell)));
      // Not periodic in z: one more cell than the depth takes.
      const int vertical = static_cast<int>(std::ceil(depth / cell)) + 2;
      levels_.push_back({GradientNoise({lateral, lateral, vertical}, seed + k), lateral / size,
                         1 / cell, std::pow(0.5, k)});
    }
  }
  [[nodiscard]] double operator()(double x, double y, double z) const {
    double sum = 0;
    for (const Level& l : levels_)
      sum += l.height * l.noise(x * l.lateral, y * l.lateral, z * l.vertical);
    return sum;
  }

 private:
  struct Level {
    GradientNoise noise;
    double lateral, vertical, height;
  };
  std::vector<Level> levels_;
};

GeneratedGrid make_dust(const Parameters& p) {
  const double size = p.number("size"), thickness = p.number("thickness");
  const double scale = p.number("scale"), contrast = p.number("contrast");
  const int n = whole(p, "voxels"), nz = voxels_along(thickness, size, n);
  const Octaves noise(size, 0, p.number("feature"), whole(p, "octaves"),
                      static_cast<std::uint64_t>(whole(p, "seed")));
  Voxels voxels(VoxelExtent{{n, n, nz}});
  constexpr double kLeast = 1e-3;  // of the density at the bottom: above it, air
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      // Log-normal heaps: the scale height is positive whatever the noise.
      const double local =
          scale * std::exp(contrast * noise((x + 0.5) / n * size, (y + 0.5) / n * size, 0.5));
      for (int z = 0; z < nz; ++z) {
        const double density = std::exp(-(z + 0.5) / nz * thickness / local);
        if (density >= kLeast) voxels.density.set({x, y, z}, {static_cast<float>(density)});
      }
    }
  return {std::move(voxels), size, size, thickness,
          "medium = \"lambert_sphere\"\nalbedo = 0.8\ndensity = 10\n"};
}

GeneratedGrid make_blotches(const Parameters& p) {
  const double size = p.number("size"), thickness = p.number("thickness");
  const double contrast = p.number("contrast");
  const int n = whole(p, "voxels"), nz = voxels_along(thickness, size, n);
  const Octaves noise(size, thickness, p.number("feature"), whole(p, "octaves"),
                      static_cast<std::uint64_t>(whole(p, "seed")));
  Voxels voxels(VoxelExtent{{n, n, nz}});
  for_each_voxel(voxels.extent(), [&](VoxelIndex i) {
    const double v =
        noise((i[0] + 0.5) / n * size, (i[1] + 0.5) / n * size, (i[2] + 0.5) / nz * thickness);
    const double density = std::max(0.0, 1 + 2 * contrast * v);
    if (density > 0) voxels.density.set(i, {static_cast<float>(density)});
  });
  return {std::move(voxels), size, size, thickness,
          "medium = \"henyey_greenstein\"\ng = 0.5\nalbedo = 0.95\ndensity = 4\n"};
}

}  // namespace

const std::vector<GridGenerator>& grid_generators() {
  static const std::vector<GridGenerator> list{
      {.name = "weave",
       .doc = "plain weave, two yarns each way, fiber flakes along the yarn",
       .parameters = {length("pitch", "from yarn to yarn", "0.5"),
                      length("width", "of a yarn, at most the pitch", "0.45"),
                      length("height", "of a yarn; the cloth is twice as thick", "0.2"),
                      {.name = "twist",
                       .unit = "1/mm",
                       .doc = "turns of the fibers about the core per length of yarn",
                       .default_value = "0.5",
                       .min = -100,
                       .max = 100},
                      count("voxels", "along x and y", "48", 8, 1024),
                      color("warp", "albedo of the yarns along y"),
                      color("weft", "albedo of the yarns along x")},
       .make = make_weave},
      {.name = "dust",
       .doc = "settled dust: densest at the bottom, in heaps",
       .parameters = {length("size", "lateral period", "1"), length("thickness", "height", "0.5"),
                      length("scale", "height over which the density falls by e", "0.1"),
                      contrast("of the heaps: exp(contrast * noise) multiplies the scale", "1"),
                      length("feature", "size of a heap", "0.33"),
                      count("octaves", "of the noise", "2", 1, 8),
                      count("voxels", "along x and y", "48", 8, 1024),
                      count("seed", "of the noise", "1", 0, 1e9)},
       .make = make_dust},
      {.name = "blotches",
       .doc = "gradient noise: density max(0, 1 + 2 contrast * noise)",
       .parameters = {length("size", "lateral period", "1"), length("thickness", "height", "0.5"),
                      contrast("0: uniform; from about 1 on, holes", "1"),
                      length("feature", "size of a blotch", "0.25"),
                      count("octaves", "of the noise", "3", 1, 8),
                      count("voxels", "along x and y", "48", 8, 1024),
                      count("seed", "of the noise", "1", 0, 1e9)},
       .make = make_blotches},
  };
  return list;
}

const GridGenerator* find_grid_generator(std::string_view name) {
  const auto& list = grid_generators();
  const auto it = std::find_if(list.begin(), list.end(),
                               [&](const GridGenerator& g) { return g.name == name; });
  return it == list.end() ? nullptr : &*it;
}

std::optional<std::string> builtin_grid_name(const std::string& file) {
  const std::string prefix = kBuiltin;
  if (!file.starts_with(prefix)) return std::nullopt;
  return file.substr(prefix.size());
}

Voxels make_builtin_grid(const std::string& name) {
  const GridGenerator* generator = find_grid_generator(name);
  if (!generator) {
    std::vector<std::string> names;
    for (const GridGenerator& g : grid_generators()) names.push_back(kBuiltin + g.name);
    const std::string hint = suggestion(kBuiltin + name, names);
    throw std::invalid_argument(fmt::format("found \"{}{}\"{}; allowed: {}", kBuiltin, name,
                                            hint.empty() ? "" : ", " + hint, listed(names)));
  }
  Parameters parameters;
  fill_defaults(generator->parameters, parameters);
  return generator->make(parameters).voxels;
}

}  // namespace lamella
