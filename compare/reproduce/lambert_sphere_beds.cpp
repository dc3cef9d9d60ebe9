#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/judge/side_by_side.h"
#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr CellGrid kCells{6, 12, true};

// Values at the middles of the cells: for models whose values are noisy anyway.
std::vector<double> at_middles(const Model& model, Direction wi) {
  std::vector<DirectionPair> pairs;
  for (int m = 0; m < kCells.rows(); ++m)
    for (int p = 0; p < kCells.columns(); ++p)
      pairs.push_back({wi, direction_from_mu_phi(std::sqrt(1 - (m + 0.5) / kCells.mu_cells),
                                                 2 * kPi * (p + 0.5) / kCells.phi_cells)});
  std::vector<Rgb> values(pairs.size());
  model.eval(pairs, values);
  std::vector<double> cells;
  for (const Rgb& v : values) cells.push_back(v.g);
  return cells;
}

}  // namespace

Json reproduce_lambert_sphere_figure_12(ReproductionContext& context) {
  constexpr double kAlbedo = 0.8, kDepth = 14;
  const std::vector<double> packings = context.quality == Quality::draft
                                           ? std::vector<double>{0.1, 3}
                                           : std::vector<double>{0.05, 0.2, 0.5, 1, 2, 3};
  const std::vector<double> alphas = context.quality == Quality::draft
                                         ? std::vector<double>{0.7, 2.4}
                                         : std::vector<double>{0.5, 0.7, 1, 1.4, 2, 2.4, 3.5, 5};
  const std::uint64_t walks = std::max<std::uint64_t>(kBatches, context.walks / packings.size());
  const int model_walks = context.by_quality(100, 2000, 20000);
  const Direction wi = direction_from_degrees(50, 0);
  NumberRows rows(context, {{"packing", "g"},
                            {"reflected", ".4f"},
                            {"alpha", "g"},
                            {"beckmann", ".4f", "Beckmann"},
                            {"sigma", ".3f"},
                            {"oren_nayar", ".4f", "Oren-Nayar"},
                            {"spheres", ".4f", "spheres"},
                            {"lambert", ".4f", "Lambert"},
                            {"noise", ".4f"}});
  rows.header(
      "deep beds of Lambertian spheres, albedo 0.8, theta_i 50: reflected light; relative RMSE of "
      "the best\nBeckmann height field and of the best full Oren-Nayar model with the same albedo, "
      "of the Lambert-\nsphere BRDF and of Lambert's law; noise of the bed");
  std::vector<std::vector<double>> fields;
  for (const double alpha : alphas)
    fields.push_back(
        at_middles(*figure_model(fmt::format("beckmann_diffuse,alpha={},albedo={},walks={}", alpha,
                                             kAlbedo, model_walks))
                        .model,
                   wi));
  std::vector<std::pair<double, std::vector<double>>> surfaces;
  for (int k = 0; k <= 15; ++k) {
    const double sigma = k * kPi / 30;
    surfaces.emplace_back(
        sigma,
        at_middles(
            *figure_model(fmt::format("oren_nayar_full,sigma={},albedo={}", sigma, kAlbedo)).model,
            wi));
  }
  const auto spheres = at_middles(
      *figure_model(fmt::format("lambert_sphere_three_term,albedo={}", kAlbedo)).model, wi);
  const auto lambert =
      at_middles(*figure_model(fmt::format("lambert,albedo={}", kAlbedo)).model, wi);
  Chart chart{.title = "Beds of spheres against height fields and the Lambert-sphere BRDF",
              .subtitle = "relative RMSE over cells, \u03b8_i = 50\u00b0, noise removed",
              .x_label = "log\u2081\u2080 of the packing",
              .y_label = "relative RMSE",
              .series = {{.label = "best Beckmann", .x = {}, .y = {}},
                         {.label = "best Oren-Nayar", .x = {}, .y = {}},
                         {.label = "Lambert-sphere BRDF", .x = {}, .y = {}}}};
  std::vector<double> best_alpha, of_field, of_spheres, energies;
  for (const double packing : packings) {
    if (is_set(context.stop)) return rows.rows();
    const Stack bed = figure_stack(
        "bed",
        fmt::format("[[layer]]\nmedium = \"sphere_bed\"\nradius = 1\npacking = {}\nthickness "
                    "= {}\nalbedo = {}\n",
                    packing, std::max(12.0, kDepth / (0.75 * packing)), kAlbedo));
    Simulation simulation(bed, make_plan(bed, {.max_order = 1000}), wi, Estimator::analog, kCells,
                          context.seed);
    run(simulation, {.walks = walks, .target_error = {}, .seconds = {}}, {}, context.stop);
    const RunResult result = reduce(simulation);
    const LobeEstimate& truth = result.reflected.lobes[Order::all];
    double alpha = 0, field = 1e9, sigma = 0, surface = 1e9;
    for (std::size_t k = 0; k < alphas.size(); ++k) {
      const double error = relative_error(truth, fields[k]).rmse;
      if (error < field) field = error, alpha = alphas[k];
    }
    for (const auto& [s, values] : surfaces) {
      const double error = relative_error(truth, values).rmse;
      if (error < surface) surface = error, sigma = s;
    }
    const RelativeError ls = relative_error(truth, spheres);
    rows.add({packing, result.reflected.total[0].value, alpha, field, sigma, surface, ls.rmse,
              relative_error(truth, lambert).rmse, ls.noise});
    best_alpha.push_back(alpha);
    of_field.push_back(field);
    of_spheres.push_back(ls.rmse);
    energies.push_back(result.reflected.total[0].value);
    const double ys[] = {field, surface, ls.rmse};
    for (int k = 0; k < 3; ++k) {
      chart.series[k].x.push_back(std::log10(packing));
      chart.series[k].y.push_back(ys[k]);
    }
  }
  context.write("error", chart);
  context.find(
      "for dense packings a random height field approximates the beds, and needs more "
      "roughness the sparser they are",
      fmt::format("the best alpha is {:g} at packing {:g} and {:g} at {:g}; relative RMSE "
                  "{:.1f} % and {:.1f} %",
                  best_alpha.back(), packings.back(), best_alpha.front(), packings.front(),
                  100 * of_field.back(), 100 * of_field.front()),
      of_field.back() < of_spheres.back() && best_alpha.back() < best_alpha.front());
  context.find(
      "for sparse packings the height-field assumption is inconsistent, the BRDF is not",
      fmt::format("at packing {:g} the BRDF is {:.1f} % off, the best height field {:.1f} %",
                  packings.front(), 100 * of_spheres.front(), 100 * of_field.front()),
      of_spheres.front() < of_field.front());
  context.find("beds darken with sparsity, because more collisions occur",
               fmt::format("reflected {:.4f} at packing {:g}, {:.4f} at {:g}", energies.back(),
                           packings.back(), energies.front(), packings.front()),
               energies.front() < energies.back());
  return rows.rows();
}

}  // namespace lamella
