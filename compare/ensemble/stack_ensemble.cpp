#include "compare/ensemble/stack_ensemble.h"

#include <fmt/format.h>

#include <cmath>

#include "analytic/spongecake_network/spongecake_ranges.h"
#include "phase/medium/media.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

constexpr double kLeastCosine = 0.02;

// Streams of one ensemble: of the stacks of each number of layers, and of their directions.
RandomStream stream_of(int layers, std::uint64_t seed, std::uint64_t number, bool directions) {
  const auto kind = static_cast<std::uint64_t>(2 * layers + (directions ? 1 : 0));
  return {seed, number + (kind << 40), StreamPurpose::measure};
}

double between(const double (&range)[2], double u) { return range[0] + u * (range[1] - range[0]); }

Rgb color_between(const double (&range)[2], RandomStream& stream) {
  const double r = stream.uniform(), g = stream.uniform(), b = stream.uniform();
  return {between(range, r), between(range, g), between(range, b)};
}

Layer random_layer(RandomStream& stream) {
  const bool fiber = stream.uniform() < 0.5, fresnel = stream.uniform() < 0.5;
  const bool at_home = stream.uniform() < 0.5;
  const double roughness = between(SpongecakeRanges::kRoughness, stream.uniform());
  const double* depth = SpongecakeRanges::kDepth;
  const double thickness = depth[0] * std::pow(depth[1] / depth[0], stream.uniform());
  const Rgb albedo = color_between(SpongecakeRanges::kAlbedo, stream);
  const Rgb f0 = color_between(SpongecakeRanges::kF0, stream);
  const double z = 2 * stream.uniform() - 1, phi = 2 * kPi * stream.uniform();
  const double mu = !at_home ? z : fiber ? 0 : 1;
  const double s = std::sqrt(1 - mu * mu);
  return flake_layer(fiber, roughness, {s * std::cos(phi), s * std::sin(phi), mu}, albedo,
                     fresnel ? f0 : Rgb(1), thickness);
}

}  // namespace

Layer flake_layer(bool fiber, double roughness, Direction axis, Rgb albedo, Rgb f0,
                  double thickness) {
  const MediumInfo& info = *find_medium("sggx");
  Layer layer{.medium_name = info.name,
              .parameters = {},
              .medium = MirrorFlakes<Sggx>{Sggx({1, 1, 1, 0, 0, 0})},
              .albedo = albedo,
              .f0 = f0,
              .thickness = thickness};
  Parameters& p = layer.parameters;
  p.set("shape", std::string(fiber ? "fiber" : "surface"));
  p.set("roughness", roughness);
  p.set("axis", std::vector<double>{axis.x, axis.y, axis.z});
  p.set("f0", f0);
  fill_defaults(info.parameters, p);
  layer.medium = info.make(p);
  return layer;
}

Stack random_spongecake_stack(int layers, std::uint64_t seed, std::uint64_t number) {
  RandomStream stream = stream_of(layers, seed, number, false);
  Stack stack{.name = fmt::format("{}_layer_{:05}",
                                  layers == 1   ? "one"
                                  : layers == 2 ? "two"
                                                : fmt::format("{}", layers),
                                  number),
              .layers = {},
              .substrate = {}};
  for (int k = 0; k < layers; ++k) stack.layers.push_back(random_layer(stream));
  return stack;
}

std::vector<Direction> random_directions(int count, int layers, std::uint64_t seed,
                                         std::uint64_t number) {
  RandomStream stream = stream_of(layers, seed, number, true);
  std::vector<Direction> directions;
  for (int k = 0; k < count; ++k) {
    const double t = (k + stream.uniform()) / count;
    directions.push_back(
        direction_from_mu_phi(kLeastCosine + t * (1 - kLeastCosine), 2 * kPi * stream.uniform()));
  }
  return directions;
}

}  // namespace lamella
