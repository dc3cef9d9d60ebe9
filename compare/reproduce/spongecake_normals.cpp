#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/spongecake_figures.h"
#include "phase/stack/single_scattering.h"
#include "volume/run/viewed_walk.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Bumps on a sphere: the gradient of a sum of waves, along the surface.
Direction bumped(Direction n, double strength) {
  Direction gradient{0, 0, 0};
  const Direction waves[] = {{17, 5, 3}, {-6, 19, 2}, {4, -9, 15}, {11, 13, -7}};
  for (const Direction k : waves) gradient = gradient + std::cos(dot(k, n)) / 18 * k;
  gradient = gradient - dot(gradient, n) * n;
  return normalized(n - strength * gradient);
}

// The half space of mirror flakes, their mean normal along `axis` in the frame of the surface.
Stack flakes_along(Direction axis, double roughness) {
  return figure_stack(
      "flakes", fmt::format("[[layer]]\nmedium = \"sggx\"\nshape = \"surface\"\naxis = [{}, {}, "
                            "{}]\nroughness = {}\nthickness = inf\n",
                            axis.x, axis.y, axis.z, roughness));
}

// A frame of a sphere's surface, z its normal.
Frame<double> sphere_frame(Direction n) {
  const Direction up = std::abs(n.y) < 0.99 ? Direction{0, 1, 0} : Direction{1, 0, 0};
  const Direction x = normalized(cross(up, n));
  return {x, cross(n, x), n};
}

// The truth: all orders, by walks from the viewer into the flakes of every pixel.
PreviewColumn walked_sphere(const ReproductionContext& context, Direction lamp, double strength,
                            double roughness) {
  const auto walks = context.by_quality<std::uint64_t>(16, 64, 1024);
  std::uint64_t pixel = 0;
  return sphere_of("flakes, all orders", [&](Direction n) {
    const std::uint64_t first = walks * pixel++;
    if (dot(n, lamp) <= 0) return Rgb();
    context.go_on();
    const Frame<double> frame = sphere_frame(n);
    const ViewedStack viewed(flakes_along(frame.to_local(bumped(n, strength)), roughness));
    const Direction wi = frame.to_local(lamp), wo = frame.to_local(Direction{0, 0, 1});
    if (!(wo.z > 0)) return Rgb();
    const LightAim aim{wi};
    Rgb sum;
    for (std::uint64_t k = 0; k < walks; ++k)
      sum += viewed.follow(wo, &aim, context.seed, first + k).f;
    return kPi * wi.z / static_cast<double>(walks) * sum;
  });
}

// Pixels that the lamp lights, and those of them that are black.
struct Black {
  int lit = 0, black = 0;
  [[nodiscard]] double share() const { return lit ? black / static_cast<double>(lit) : 0; }
};

Black black_pixels(const PreviewColumn& column, Direction lamp) {
  Black result;
  const PreviewColumn normals = sphere_of("", [](Direction n) { return Rgb(n.x, n.y, n.z); });
  for (std::size_t k = 0; k < normals.image.radiance.size(); ++k) {
    if (!normals.image.covered[k]) continue;
    const Rgb n = normals.image.radiance[k];
    if (dot(Direction{n.r, n.g, n.b}, lamp) <= 0) continue;
    ++result.lit;
    result.black += column.image.radiance[k] == Rgb();
  }
  return result;
}

}  // namespace

Json reproduce_spongecake_figure_15(ReproductionContext& context) {
  constexpr double kRoughness = 0.4;
  const Direction lamp = direction_from_degrees(60, 30);
  const BoundModel facets = figure_model(
      fmt::format("microfacet,material=white,distribution=ggx,roughness={}", kRoughness));
  NumberRows rows(context, {{"strength", "g"},
                            {"facets_black", ".4f", "facets"},
                            {"flakes_black", ".4f", "flakes"},
                            {"truth_black", ".4f", "truth"},
                            {"facets_luminance", ".4f", "luminance"},
                            {"flakes_luminance", ".4f", "flakes'"},
                            {"truth_luminance", ".4f", "truth's"}});
  rows.header(
      "roughness 0.4, lamp at 60 degrees, normals bumped by a strength: share of the lit pixels "
      "that are\nblack, where the map turns the surface, and where it turns the flakes of a half "
      "space (twice single\nscattering; the truth: all orders, by walks); mean luminances");
  double facets_black = 0, flakes_black = 0, truth_black = 0;
  for (const double strength : context.quality == Quality::draft
                                   ? std::vector<double>{0.6}
                                   : std::vector<double>{0, 0.3, 0.6}) {
    if (is_set(context.stop)) return rows.rows();
    const PreviewColumn surface = sphere_of("microfacets", [&](Direction n) {
      if (dot(n, lamp) <= 0) return Rgb();
      const Direction m = bumped(n, strength);
      const double mu_i = dot(m, lamp), mu_o = m.z;
      // Below the turned surface nothing is reflected.
      if (mu_i <= 0 || mu_o <= 0) return Rgb();
      const Direction a = lamp - mu_i * m, b = Direction{0, 0, 1} - mu_o * m;
      const double lengths = std::sqrt(dot(a, a) * dot(b, b));
      const double phi = lengths > 0 ? std::acos(std::clamp(dot(a, b) / lengths, -1.0, 1.0)) : 0;
      return kPi * mu_i *
             facets.model->eval(direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, phi));
    });
    const PreviewColumn flakes = sphere_of("flakes", [&](Direction n) {
      if (dot(n, lamp) <= 0) return Rgb();
      const Frame<double> frame = sphere_frame(n);
      const Stack stack = flakes_along(frame.to_local(bumped(n, strength)), kRoughness);
      const Direction wi = frame.to_local(lamp), wo = frame.to_local(Direction{0, 0, 1});
      return 2 * kPi * wi.z * single_scattering(stack, wi, wo).layers;
    });
    const PreviewColumn truth = walked_sphere(context, lamp, strength, kRoughness);
    const Black of_facets = black_pixels(surface, lamp), of_flakes = black_pixels(flakes, lamp),
                of_truth = black_pixels(truth, lamp);
    rows.add({strength, of_facets.share(), of_flakes.share(), of_truth.share(),
              luminance_of(surface).mean, luminance_of(flakes).mean, luminance_of(truth).mean});
    facets_black = of_facets.share();
    flakes_black = of_flakes.share();
    truth_black = of_truth.share();
    write_gallery(context, fmt::format("strength_{:g}", strength),
                  fmt::format("the same map of normals, strength {:g}", strength),
                  {surface, flakes, truth});
  }
  context.find(
      "a normal map makes black spots on a microfacet surface, a map of the flakes' "
      "orientation does not",
      fmt::format("at the highest strength {:.2f} % of the lit pixels are black with "
                  "facets, {:.2f} % with flakes, {:.2f} % of their truth",
                  100 * facets_black, 100 * flakes_black, 100 * truth_black),
      facets_black > 0.005 && flakes_black == 0 && truth_black == 0);
  return rows.rows();
}

}  // namespace lamella
