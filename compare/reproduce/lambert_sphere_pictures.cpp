#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/half_space/lambert_sphere_models.h"
#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/uniform_light.h"
#include "compare/request/stopwatch.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// The lit part of a picture: the mean radiance of its outermost tenth of the radius, and the
// standard deviation over the whole, over its mean.
struct LitPart {
  double silhouette = 0, contrast = 0;
};

LitPart lit_part(const PreviewColumn& column) {
  double rim = 0, rim_pixels = 0, sum = 0, square = 0, pixels = 0;
  const PreviewImage& image = column.image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto k = static_cast<std::size_t>(y) * image.width + x;
      if (!image.covered[k] || image.radiance[k] == Rgb()) continue;
      const double u = (2 * x + 1.0) / image.width - 1, v = (2 * y + 1.0) / image.height - 1;
      const double value = image.radiance[k].g;
      sum += value;
      square += value * value;
      ++pixels;
      if (1.04 * std::hypot(u, v) < 0.9) continue;
      rim += value;
      ++rim_pixels;
    }
  const double mean = sum / pixels;
  return {rim / rim_pixels, std::sqrt(std::max(0.0, square / pixels - mean * mean)) / mean};
}

struct Light {
  const char* name;
  double lamp;
};

// Pictures of several models under several lamps, all reflecting the same colour of uniform light.
struct Gallery {
  std::vector<std::string> names;
  std::vector<BoundModel> models;
  std::vector<Light> lights;
  // By light, then model.
  std::vector<std::vector<double>> luminance{}, red_over_blue{}, rim{};
};

Json draw_gallery_of(ReproductionContext& context, Gallery& gallery) {
  NumberRows rows(context, {{"light", "", "", 11},
                            {"model", "", "", 15},
                            {"luminance", ".4f"},
                            {"saturation", ".4f"},
                            {"silhouette", ".4f"}});
  rows.header(
      "all reflect the same colour of uniform light; mean luminance, red over blue, radiance of "
      "the "
      "lit part's\nouter tenth");
  for (const Light& light : gallery.lights) {
    std::vector<PreviewColumn> columns;
    std::vector<double> l, s, r;
    for (std::size_t m = 0; m < gallery.models.size(); ++m) {
      if (is_set(context.stop)) return rows.rows();
      // Height fields are walked in every pixel.
      const Model& model = *gallery.models[m].model;
      const auto towards = [&](Direction wo) {
        return [&model, &context, wo](Direction wi) {
          context.go_on();
          return model.eval(wi, wo);
        };
      };
      columns.push_back(lit_sphere(gallery.names[m], towards, sphere_view(light.lamp)));
      l.push_back(luminance_of(columns.back()).mean);
      s.push_back(saturation(columns.back()));
      r.push_back(lit_part(columns.back()).silhouette);
      rows.add({light.name, gallery.names[m], l.back(), s.back(), r.back()});
    }
    gallery.luminance.push_back(l);
    gallery.red_over_blue.push_back(s);
    gallery.rim.push_back(r);
    write_gallery(context, light.name, fmt::format("lit from the {}", light.name), columns);
  }
  return rows.rows();
}

constexpr Rgb kColor(0.6, 0.4, 0.2);

}  // namespace

Json reproduce_lambert_sphere_figure_8(ReproductionContext& context) {
  // The paper gives no roughness of its height fields.
  constexpr double kAlpha = 1.4, kSigma = kPi / 3;
  const std::uint64_t walks = std::clamp<std::uint64_t>(context.walks / 2000, 2, 300);
  Gallery gallery{.names = {"Lambert spheres", "Beckmann", "Oren-Nayar", "Chandrasekhar"},
                  .models = {},
                  .lights = {{"front", 0}, {"upper_right", 45}, {"side", 90}, {"behind", 140}}};
  gallery.models.push_back(figure_model(with_bond_albedo("lambert_sphere_three_term", kColor)));
  // Its albedo is a mean over many directions, which takes fewer walks than a pixel does.
  const std::string beckmann = fmt::format("beckmann_diffuse,alpha={},walks={}", kAlpha,
                                           std::min<std::uint64_t>(walks, 16));
  std::string bright = with_bond_albedo(beckmann, kColor);
  bright.replace(0, beckmann.size(),
                 fmt::format("beckmann_diffuse,alpha={},walks={}", kAlpha, walks));
  gallery.models.push_back(figure_model(bright));
  gallery.models.push_back(
      figure_model(with_bond_albedo(fmt::format("oren_nayar_full,sigma={}", kSigma), kColor)));
  gallery.models.push_back(figure_model(with_bond_albedo("chandrasekhar", kColor)));
  context.say(fmt::format("Beckmann alpha {:g} ({} walks a pixel), Oren-Nayar sigma {:.3f}\n",
                          kAlpha, walks, kSigma));
  Json rows = draw_gallery_of(context, gallery);
  if (gallery.luminance.size() < gallery.lights.size()) return rows;
  const auto& front = gallery.luminance.front();
  context.find("the Lambert-sphere BRDF scatters more back than the other models",
               fmt::format("mean luminance lit from the front: {:.4f}, Beckmann {:.4f}, Oren-Nayar "
                           "{:.4f}, Chandrasekhar {:.4f}",
                           front[0], front[1], front[2], front[3]),
               front[0] > std::max({front[1], front[2], front[3]}));
  const auto& behind = gallery.red_over_blue.back();
  context.find(
      "its silhouettes are saturated in light from behind",
      fmt::format("red over blue {:.2f}, Beckmann {:.2f}, Oren-Nayar {:.2f}, Chandrasekhar "
                  "{:.2f}",
                  behind[0], behind[1], behind[2], behind[3]),
      behind[0] > std::max({behind[1], behind[2], behind[3]}));
  return rows;
}

Json reproduce_lambert_sphere_figure_10(ReproductionContext& context) {
  Gallery gallery{.names = {"Lambert spheres", "Lambert", "Oren-Nayar", "Chandrasekhar"},
                  .models = {},
                  .lights = {{"front", 15}, {"behind", 130}}};
  for (const char* request :
       {"lambert_sphere_three_term", "lambert", "oren_nayar_full,sigma=0.7", "chandrasekhar"})
    gallery.models.push_back(figure_model(with_bond_albedo(request, kColor)));
  Json rows = draw_gallery_of(context, gallery);
  if (gallery.luminance.size() < gallery.lights.size()) return rows;
  const auto& front = gallery.luminance[0];
  const auto& rim = gallery.rim[1];
  context.find(
      "the BRDF shows increased back scattering in light from the front",
      fmt::format("mean luminance {:.4f}; Lambert {:.4f}, Oren-Nayar {:.4f}, Chandrasekhar "
                  "{:.4f}",
                  front[0], front[1], front[2], front[3]),
      front[0] > std::max({front[1], front[2], front[3]}));
  context.find(
      "it does not have the glowing silhouettes of Chandrasekhar's BRDF in light from "
      "behind",
      fmt::format("radiance of the outer tenth {:.4f}, Chandrasekhar {:.4f}", rim[0], rim[3]),
      rim[0] < rim[3]);
  return rows;
}

Json reproduce_lambert_sphere_figure_11(ReproductionContext& context) {
  const Rgb kd(0.18, 0.05, 0.6);  // the caption's
  const Rgb c(lambert_sphere_albedo(kd.r), lambert_sphere_albedo(kd.g),
              lambert_sphere_albedo(kd.b));
  const std::string color = fmt::format("{}, {}, {}", c.r, c.g, c.b);
  const Stack spheres = figure_stack(
      "spheres", fmt::format("[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = [{}]\nthickness = "
                             "inf\n",
                             color));
  // Henyey-Greenstein of the same mean cosine and albedo.
  const Stack haze = figure_stack(
      "haze", fmt::format("[[layer]]\nmedium = \"henyey_greenstein\"\ng = {}\nalbedo = "
                          "[{}]\nthickness = inf\n",
                          -4.0 / 9, color));
  const std::uint64_t walks =
      std::max<std::uint64_t>(kBatches, context.walks / HalfVectorGrid::kOut);
  const PreviewView view = sphere_view(90);
  NumberRows rows(context, {{"picture", "", "", 26},
                            {"seconds", ".4f"},
                            {"seconds_of_table", ".3f", "table"},
                            {"relative_rmse", ".5f", "RMSE"},
                            {"mean", "+.5f"}});
  rows.header(
      fmt::format("k_d (0.18, 0.05, 0.6), c ({:.4f}, {:.4f}, {:.4f}) by eq. 46, lamp at 90 "
                  "degrees: time of the picture\nand of the table before it; relative RMSE "
                  "and mean difference from the solver's",
                  c.r, c.g, c.b));
  std::vector<PreviewColumn> columns;
  std::vector<double> picture_seconds, table_seconds;
  const auto add = [&](const std::string& name, double table, const auto& draw) {
    picture_seconds.push_back(wall_seconds_of([&] { columns.push_back(draw()); }));
    table_seconds.push_back(table);
    const SphereDifference d = difference(columns.back(), columns.front());
    rows.add({name, picture_seconds.back(), table, d.rmse, d.mean});
  };
  std::optional<LobeTable> solved, walked, hazy;
  const double solver = wall_seconds_of([&] { solved = solved_table(spheres, context); });
  add("solver", solver, [&] { return lit_sphere("solver", *solved, view); });
  const BoundModel analytic =
      figure_model(fmt::format("lambert_sphere,albedo={},{},{}", c.r, c.g, c.b));
  add("analytic", 0, [&] { return lit_sphere("analytic", *analytic.model, view); });
  const double walk = wall_seconds_of([&] { walked = walked_table(spheres, walks, context); });
  add(fmt::format("walks ({} per angle)", walks), walk,
      [&] { return lit_sphere("walks", *walked, view); });
  const double hg = wall_seconds_of([&] { hazy = solved_table(haze, context); });
  add("Henyey-Greenstein", hg, [&] { return lit_sphere("Henyey-Greenstein", *hazy, view); });
  write_spheres(context, "side", "Lambert spheres, lit from the side", columns);
  const Rgb bond = quick_average_albedo(*analytic.model);
  context.find(
      "k_d is the reflected share of uniform light, by eq. 46",
      fmt::format("the analytic form reflects ({:.3f}, {:.3f}, {:.3f})", bond.r, bond.g, bond.b),
      std::max({std::abs(bond.r - kd.r), std::abs(bond.g - kd.g), std::abs(bond.b - kd.b)}) < 0.02);
  context.find("the analytic form looks as the doubling result does",
               fmt::format("relative RMSE {:.2f} %", 100 * difference(columns[1], columns[0]).rmse),
               difference(columns[1], columns[0]).rmse < 0.05);
  context.find("the analytic form renders faster than the doubling method",
               fmt::format("{:.4f} s against {:.4f} s and {:.2f} s for the table before it",
                           picture_seconds[1], picture_seconds[0], table_seconds[0]),
               picture_seconds[1] < picture_seconds[0] + table_seconds[0]);
  context.find(
      "Henyey-Greenstein of the same mean cosine has a flatter appearance in light from "
      "the side",
      fmt::format("standard deviation over mean of the lit part {:.3f}, of the spheres {:.3f}",
                  lit_part(columns[3]).contrast, lit_part(columns[0]).contrast),
      lit_part(columns[3]).contrast < lit_part(columns[0]).contrast);
  return rows.rows();
}

}  // namespace lamella
