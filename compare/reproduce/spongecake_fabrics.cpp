#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/reproduce/cell_table_model.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/spongecake_figures.h"
#include "compare/reproduce/spongecake_scenes.h"
#include "compare/reproduce/traced_scene.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// The angle of the fibers that lie on top of a weave: threads along u and along v take turns, and
// are not quite straight.
double weave_angle(double u, double v, int threads) {
  const int i = static_cast<int>(std::floor(u * threads)),
            j = static_cast<int>(std::floor(v * threads));
  constexpr double kJitter = 8 * kPi / 180;
  return ((i + j) % 2 ? kPi / 2 : 0) + kJitter * wavy(u, v, 3, 5);
}

// A window's shade that hangs in folds; z is the room.
TriangleMesh shade() {
  return patch(192, 24, [](double u, double v) {
    return Direction{2.4 * u - 1.2, 2 * v - 1, 0.09 * std::sin(2 * kPi * 4 * u)};
  });
}

std::string shade_text(double u, double v) {
  const double a = weave_angle(u, v, 32);
  const Direction axis{std::cos(a), std::sin(a), 0};
  return flake_layer("fiber", axis, 0.1, {0.9, 0.9, 0.7}, 1, 1) +
         flake_layer("fiber", axis, 1, {0.9, 0.9, 0.7}, 1, 1);
}

std::string fabric_text_at(double angle) {
  return flake_layer("fiber", {std::cos(angle), std::sin(angle), 0}, 0.5, {0.7, 0.1, 0.1}, 1, 1) +
         flake_layer("surface", {0, 0, 1}, 0.8, {0.7, 0.1, 0.1}, 1, 5);
}

std::string fabric_text(double u, double v) { return fabric_text_at(weave_angle(u, v, 48)); }

}  // namespace

Json reproduce_spongecake_figure_1(ReproductionContext& context) {
  const ViewedObject object(shade());
  const Direction sun = normalized(Direction{0.35, 0.7, -0.6}),
                  lamp = normalized(Direction{-0.5, 0.25, 0.83});
  const auto truth = walked_texture(shade_text);
  const auto network = closed_texture(shade_text, "spongecake");
  const auto single = closed_texture(shade_text, "spongecake,lobes=none");
  const std::vector<NamedSurface> surfaces{
      {"truth", truth.get()}, {"SpongeCake", network.get()}, {"single scattering", single.get()}};
  NumberRows rows(context, {{"light", "", "", 12},
                            {"picture", "", "", 18},
                            {"luminance", ".4f"},
                            {"bright", ".3f", "brightest"},
                            {"bias", ".4f", "bias^2"},
                            {"flip", ".4f", "FLIP"}});
  rows.header(
      "a shade in folds: mean luminance, the brightest per cent over the mean, relative mean "
      "square "
      "error without noise and FLIP from the truth by walks");
  const int samples = context.by_quality(32, 256, 4096);
  std::vector<NamedPicture> by_sun, by_lamp, by_both;
  for (const NamedSurface& s : surfaces) {
    if (is_set(context.stop)) return rows.rows();
    by_sun.push_back(
        traced(context, s.name, object, LightDome(SkyKind::none, sun), *s.surface, samples));
    by_lamp.push_back(
        traced(context, s.name, object, LightDome(SkyKind::none, lamp), *s.surface, samples));
    by_both.push_back({s.name, sum_of(by_sun.back().picture, by_lamp.back().picture)});
  }
  double bias_network = 0, bias_single = 0, bright_sun = 0, bright_lamp = 0;
  for (const auto& [light, pictures] :
       {std::pair("sun outside", &by_sun), std::pair("lamp inside", &by_lamp),
        std::pair("both", &by_both)}) {
    const bool both = pictures == &by_both;
    for (const NamedPicture& p : *pictures) {
      const TracedError error = traced_error(pictures->front().picture, p.picture);
      const PictureLuminance l = luminance_of(p.picture);
      // The sum of two pictures has no variance of its own.
      const double bias = both ? std::nan("") : error.bias;
      rows.add({light, p.name, l.mean, l.bright / l.mean, bias, error.flip});
      if (both) continue;
      if (p.name == "SpongeCake") bias_network = std::max(bias_network, bias);
      if (p.name == "single scattering") bias_single = std::max(bias_single, bias);
      if (p.name == "truth") (pictures == &by_sun ? bright_sun : bright_lamp) = l.bright / l.mean;
    }
    write_traced(context,
                 pictures == &by_sun    ? "sun"
                 : pictures == &by_lamp ? "lamp"
                                        : "both",
                 fmt::format("window shade, {}", light), *pictures, true);
  }
  context.find(
      "sunlight from outside is transmitted diffusely, a lamp inside makes a specular sheen",
      fmt::format("the brightest per cent of the picture is {:.1f} times the mean under the sun, "
                  "{:.1f} times under the lamp",
                  bright_sun, bright_lamp),
      bright_lamp > 1.5 * bright_sun);
  context.find("the multiple scattering approximation is effective",
               fmt::format("relative mean square error of the worse light {:.3f} with the "
                           "network's lobes, {:.3f} without",
                           bias_network, bias_single),
               bias_network < 0.25 * bias_single);
  return rows.rows();
}

Json reproduce_spongecake_figure_17(ReproductionContext& context) {
  const ViewedObject object("cloth");
  const LightDome light(SkyKind::clear, normalized(Direction{0.5, 0.7, 0.5}));
  const auto truth = walked_texture(fabric_text);
  const auto network = closed_texture(fabric_text, "spongecake");
  const auto single = closed_texture(fabric_text, "spongecake,lobes=none");
  const auto table = std::make_shared<const CellTable>(
      figure_stack("fabric", fabric_text_at(0)),
      context.by_quality<std::uint64_t>(256, 16384, 262144), context);
  constexpr int kPlaces = 128;
  const auto tabulated =
      closed_surface({kPlaces, kPlaces,
                      [&](double u, double v) -> std::unique_ptr<Model> {
                        const double angle = weave_angle(u, v, 48);
                        return std::make_unique<TabulatedStack>(
                            figure_stack("fabric", fabric_text_at(angle)), angle, table);
                      }},
                     true);
  const EqualTime found = equal_time(context, object, light, *truth,
                                     {{"walks", truth.get()},
                                      {"SpongeCake", network.get()},
                                      {"single scattering", single.get()},
                                      {"table", tabulated.get()}});
  NumberRows rows(context, {{"picture", "", "", 18},
                            {"samples", ".0f"},
                            {"luminance", ".4f"},
                            {"noise", ".5f"},
                            {"mse", ".5f", "MSE"},
                            {"bias", ".5f", "bias^2"},
                            {"flip", ".4f", "FLIP"}});
  rows.header(fmt::format(
      "a woven cloth under a clear sky, {:g} s for each picture: samples per pixel, relative mean "
      "square errors (noise; all; all without noise) and FLIP from a reference by walks",
      context.by_quality(0.1, 1.5, 20.0)));
  for (std::size_t k = 0; k < found.pictures.size(); ++k) {
    const TracedError& e = found.errors[k];
    const PathPicture& p = found.pictures[k].picture;
    rows.add({found.pictures[k].name,
              static_cast<double>(*std::max_element(p.samples.begin(), p.samples.end())),
              luminance_of(p).mean, e.noise, e.difference, e.bias, e.flip});
  }
  if (found.errors.size() < 4) return rows.rows();
  const TracedError &walks = found.errors[0], &model = found.errors[1], &none = found.errors[2],
                    &cells = found.errors[3];
  std::vector<NamedPicture> pictures{found.reference};
  pictures.insert(pictures.end(), found.pictures.begin(), found.pictures.end());
  write_traced(context, "fabric", "fabric, equal time", pictures, true);
  context.find(
      "the full model is very similar to the reference",
      fmt::format("relative mean square error without noise {:.4f}, {:.4f} without the lobes of "
                  "multiple scattering; FLIP {:.3f} against {:.3f}",
                  model.bias, none.bias, model.flip, none.flip),
      model.bias < 0.02 && model.bias < none.bias);
  context.find("at equal time the closed form has much less noise than walks",
               fmt::format("noise {:.4f} against {:.4f} of walks, {:.4f} of the table; by sample "
                           "{:.2f} times that of walks",
                           model.noise, walks.noise, cells.noise,
                           noise_per_sample(found, 1) / noise_per_sample(found, 0)),
               model.noise < 0.5 * walks.noise);
  context.find("its mean square error is not much lower than that of walks, for its bias",
               fmt::format("{:.4f} against {:.4f} of walks, {:.4f} of the table", model.difference,
                           walks.difference, cells.difference),
               model.difference < walks.difference && model.difference > 0.25 * walks.difference);
  return rows.rows();
}

}  // namespace lamella
