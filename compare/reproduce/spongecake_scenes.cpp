#include "compare/reproduce/spongecake_scenes.h"

#include <fmt/format.h>

#include <cmath>

#include "compare/reproduce/lit_spheres.h"

namespace lamella {
namespace {

// Texels of the generated textures along u and v.
constexpr int kTexels = 128;

Stack stack_at(const StackText& text, double u, double v) {
  return figure_stack("texture", text(u, v));
}

}  // namespace

std::unique_ptr<SurfaceScatter> walked_texture(const StackText& text) {
  return walked_surface(
      {kTexels, kTexels, [text](double u, double v) { return stack_at(text, u, v); }}, {});
}

std::unique_ptr<SurfaceScatter> closed_texture(const StackText& text, const std::string& request) {
  const Stack middle = stack_at(text, 0.5, 0.5);
  const PlacedRequest placed = placed_request(parse_model_request(request), middle);
  return closed_surface({kTexels, kTexels,
                         [text, placed](double u, double v) {
                           return std::move(model_at(placed, stack_at(text, u, v)).model);
                         }},
                        middle.is_open_below());
}

std::string flake_layer(const std::string& shape, Direction axis, double roughness, Rgb albedo,
                        double f0, double thickness) {
  return fmt::format(
      "[[layer]]\nmedium = \"sggx\"\nshape = \"{}\"\naxis = [{:.6f}, {:.6f}, {:.6f}]\nroughness = "
      "{}\nalbedo = [{}, {}, {}]\nf0 = {}\nthickness = {}\n",
      shape, axis.x, axis.y, axis.z, roughness, albedo.r, albedo.g, albedo.b, f0, thickness);
}

double wavy(double u, double v, int waves, std::uint64_t seed) {
  double sum = 0, square = 0;
  std::uint64_t state = seed * 0x9E3779B97F4A7C15ULL + 1;
  const auto next = [&] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) / static_cast<double>(1ULL << 53);
  };
  for (int i = 0; i <= waves; ++i)
    for (int j = -waves; j <= waves; ++j) {
      const double phase = next();
      if (i * i + j * j == 0 || i * i + j * j > waves * waves) continue;
      const double weight = 1 / std::sqrt(i * i + j * j);
      sum += weight * std::sin(2 * kPi * (i * u + j * v + phase));
      square += weight * weight / 2;
    }
  // Twice the standard deviation is 1.
  return sum / (2 * std::sqrt(square));
}

}  // namespace lamella
