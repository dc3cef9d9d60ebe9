#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/spongecake_figures.h"
#include "compare/reproduce/spongecake_scenes.h"
#include "compare/reproduce/traced_scene.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// The best two lobes of a board whose fibers and base have the albedo (0.6, 0.4, 0.2), fibers along
// x, as `lamella fit` finds them. They are factors of the layers' own numbers.
constexpr const char* kLobes =
    "spongecake,second_weight=1,lambert_reflect=0.02106,0.005992,0.0009765,"
    "lambert_transmit=0.001721,0.0003978,0.00006738,second_roughness_1=19.98,second_depth_1=1.263,"
    "second_albedo_1=0.6157,0.2844,0.09621,second_f0_1=0,0.000396,0.03989,second_roughness_2=1.408,"
    "second_depth_2=0.4281,second_albedo_2=1.337,1.041,0.7206,second_f0_2=0.3309,0.2582,0.1728,"
    "second_roughness_3=1.249,second_depth_3=1.734,second_albedo_3=50.76,24.77,6.774,second_f0_3=0";

// A generated wood: colours of early and late wood, rings across the board, and how far the fibers
// rise out of the plane and by how many waves (curl).
struct Wood {
  const char* name;
  Rgb early, late;
  double rise;
  int curls;
};

// The papers' woods by name; all numbers are chosen here.
const Wood kWoods[] = {{"padauk", {0.75, 0.3, 0.15}, {0.5, 0.12, 0.06}, 0.15, 3},
                       {"walnut", {0.5, 0.33, 0.2}, {0.22, 0.13, 0.08}, 0.15, 2},
                       {"curly maple", {0.85, 0.66, 0.42}, {0.68, 0.46, 0.25}, 0.35, 9}};

std::string wood_text(const Wood& wood, double u, double v) {
  const double ring = 0.5 + 0.5 * std::sin(2 * kPi * (7 * v + 0.8 * wavy(u, v, 2, 21)));
  const Rgb albedo = wood.early + ring * ring * (wood.late - wood.early);
  // Fibers run along u, turn with the rings and rise in waves.
  const double turn = 0.15 * wavy(u, v, 3, 22);
  const double rise = wood.rise * std::sin(2 * kPi * (wood.curls * u + 0.5 * wavy(u, v, 3, 23)));
  const Direction axis{std::cos(turn) * std::cos(rise), std::sin(turn) * std::cos(rise),
                       std::sin(rise)};
  return flake_layer("surface", {0, 0, 1}, 0.05, Rgb(1), 0.1, 0.1) +
         flake_layer("fiber", axis, 0.2, albedo, 1, 1) +
         flake_layer("surface", {0, 0, 1}, 0.8, albedo, 1, 5);
}

// A board, bent a little, so that lights have a place on it.
TriangleMesh board() {
  return patch(96, 96, [](double u, double v) {
    const double x = 2 * u - 1, y = 2 * v - 1;
    return Direction{x, y, -0.15 * (x * x + y * y)};
  });
}

}  // namespace

Json reproduce_spongecake_figure_19(ReproductionContext& context) {
  const ViewedObject object(board());
  const LightDome light(SkyKind::clear, normalized(Direction{0.35, 0.55, 0.75}));
  NumberRows rows(context, {{"wood", "", "", 12},
                            {"picture", "", "", 12},
                            {"samples", ".0f"},
                            {"luminance", ".4f"},
                            {"noise", ".5f"},
                            {"mse", ".5f", "MSE"},
                            {"bias", ".5f", "bias^2"},
                            {"flip", ".4f", "FLIP"}});
  rows.header(fmt::format(
      "varnished boards under a clear sky, {:g} s for each picture: samples per pixel, relative "
      "mean square errors (noise; all; all without noise) and FLIP from a reference by walks",
      context.by_quality(0.1, 1.5, 20.0)));
  double most_noise = 0, per_sample = 0, least_mse = 1e9, most_mse = 0;
  for (const Wood& wood : kWoods) {
    if (is_set(context.stop)) return rows.rows();
    const StackText text = [&wood](double u, double v) { return wood_text(wood, u, v); };
    const auto truth = walked_texture(text);
    // The network knows no three layers.
    const auto model = closed_texture(text, kLobes);
    const EqualTime found = equal_time(context, object, light, *truth,
                                       {{"walks", truth.get()}, {"SpongeCake", model.get()}});
    for (std::size_t k = 0; k < found.pictures.size(); ++k) {
      const TracedError& e = found.errors[k];
      const PathPicture& p = found.pictures[k].picture;
      rows.add({wood.name, found.pictures[k].name,
                static_cast<double>(*std::max_element(p.samples.begin(), p.samples.end())),
                luminance_of(p).mean, e.noise, e.difference, e.bias, e.flip});
    }
    if (found.errors.size() < 2) return rows.rows();
    most_noise = std::max(most_noise, found.errors[1].noise / found.errors[0].noise);
    per_sample = std::max(per_sample, noise_per_sample(found, 1) / noise_per_sample(found, 0));
    const double mse = found.errors[1].difference / found.errors[0].difference;
    least_mse = std::min(least_mse, mse);
    most_mse = std::max(most_mse, mse);
    std::vector<NamedPicture> pictures{found.reference};
    pictures.insert(pictures.end(), found.pictures.begin(), found.pictures.end());
    std::string file = wood.name;
    std::replace(file.begin(), file.end(), ' ', '_');
    write_traced(context, file, fmt::format("{}, equal time", wood.name), pictures, true);
  }
  context.find("at equal time the closed form has much less noise than walks",
               fmt::format("at most {:.2f} times the noise of walks; by sample, {:.2f} times",
                           most_noise, per_sample),
               most_noise < 0.5);
  context.find("its mean square error is much smaller",
               fmt::format("{:.2f} to {:.2f} times that of walks", least_mse, most_mse),
               most_mse < 0.5);
  return rows.rows();
}

}  // namespace lamella
