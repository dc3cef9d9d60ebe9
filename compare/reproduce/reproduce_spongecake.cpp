#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/drawing/chart.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/spongecake_figures.h"
#include "compare/request/interrupt.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// f mu_o of light from theta_i = 45 degrees over theta_o in the plane of incidence.
ChartSeries slice(const std::string& label, const Model& model) {
  ChartSeries series{.label = label, .x = {}, .y = {}};
  const Direction wi = direction_from_degrees(45, 0);
  for (int theta = -88; theta <= 88; theta += 2) {
    const Direction wo = direction_from_degrees(std::abs(theta), theta < 0 ? 180 : 0);
    series.x.push_back(theta);
    series.y.push_back(model.eval(wi, wo).g * wo.z);
  }
  return series;
}

}  // namespace

Json reproduce_spongecake_figure_14(ReproductionContext& context) {
  Json rows = Json::array();
  if (context.table)
    fmt::print(context.table,
               "white mirrors; spheres under a lamp at {:g} degrees; single scattering of the half "
               "space, doubled,\nless the facets', relative: root mean square, of the mean\n"
               "{:>9} {:<12} {:>9} {:>9} {:>9} {:>9}\n",
               kSphereLamp, "roughness", "masking", "luminance", "flakes", "RMSE", "mean");
  double smith = 0, walter = 0;
  for (const double alpha : {0.1, 0.3, 0.5, 0.8, 1.0}) {
    if (is_set(context.stop)) return rows;
    const Stack stack = figure_stack(
        "flakes",
        fmt::format("[[layer]]\nmedium = \"sggx\"\nroughness = {}\nthickness = inf\n", alpha));
    const BoundModel flakes = figure_model("single_scattering", &stack);
    const PreviewColumn doubled = lit_sphere("SGGX, doubled", *flakes.model, 2);
    std::vector<PreviewColumn> columns;
    for (const std::string masking : {"beta", "separable"}) {
      const BoundModel facets = figure_model(
          fmt::format("microfacet,material=white,roughness={},masking={}", alpha, masking));
      columns.push_back(lit_sphere("GGX, " + masking, *facets.model));
      const SphereDifference d = difference(doubled, columns.back());
      (masking == "beta" ? smith : walter) = std::max(masking == "beta" ? smith : walter, d.rmse);
      const double mean = luminance_of(columns.back()).mean, of_flakes = luminance_of(doubled).mean;
      if (context.table)
        fmt::print(context.table, "{:>9g} {:<12} {:>9.5f} {:>9.5f} {:>9.1e} {:>+9.1e}\n", alpha,
                   masking, mean, of_flakes, d.rmse, d.mean);
      rows.push_back({{"roughness", alpha},
                      {"masking", masking},
                      {"facets", mean},
                      {"flakes", of_flakes},
                      {"relative_rmse", d.rmse},
                      {"mean", d.mean}});
    }
    columns.push_back(doubled);
    write_spheres(context, fmt::format("roughness_{:g}", alpha),
                  fmt::format("GGX facets and SGGX flakes, alpha = {:g}", alpha), columns);
  }
  context.find(
      "the difference from the microfacet model is surprisingly minor",
      fmt::format("none ({:.0e}) from facets masked at the same heights, of which the "
                  "doubled half space is the closed form; up to {:.0f} % from facets masked "
                  "independently",
                  smith, 100 * walter),
      smith < 1e-6);
  return rows;
}

Json reproduce_spongecake_figure_16(ReproductionContext& context) {
  // The paper tells no thickness: one optical depth of fibers seen from the side, and a half space.
  Json rows = Json::array();
  if (context.table)
    fmt::print(
        context.table,
        "white, over black; fibers along the normal, one optical depth seen from the side, or a "
        "half space; spheres\nunder a lamp at {:g} degrees: mean luminance, and that of the rim "
        "(mu_o < {:g}) over it\n{:>9} |{:^19}|{:^19}|{:^19}|{:^19}\n",
        kSphereLamp, kRimCosine, "roughness", "facets", "fibers, order 1", "half space",
        "fibers, all orders");
  Chart chart{.title = "Sheen of fibers and of facets",
              .subtitle =
                  "in the plane of incidence, \u03b8_i = 45\u00b0; \u03b8_o > 0 on the side "
                  "of the light",
              .x_label = "\u03b8_o [degrees]",
              .y_label = "f cos \u03b8_o [sr\u207b\u00b9]",
              .series = {}};
  const auto fibers_of = [](double roughness, const std::string& thickness) {
    return figure_stack(
        "fibers", fmt::format("[[layer]]\nmedium = \"sggx\"\nshape = \"fiber\"\naxis = [0, 0, 1]\n"
                              "roughness = {}\nthickness = {}\n",
                              roughness, thickness));
  };
  std::vector<std::vector<SphereLuminance>> seen;
  const std::vector<double> roughnesses = context.quality == Quality::draft
                                              ? std::vector<double>{0.4, 1.0}
                                              : std::vector<double>{0.1, 0.2, 0.4, 0.7, 1.0};
  for (const double roughness : roughnesses) {
    if (is_set(context.stop)) return rows;
    const Stack layer = fibers_of(roughness, "1"), half_space = fibers_of(roughness, "inf");
    const BoundModel fibers = figure_model("single_scattering", &layer);
    const BoundModel deep = figure_model("single_scattering", &half_space);
    const BoundModel facets =
        figure_model(fmt::format("sheen_conty_kulla,roughness={}", roughness));
    const std::vector<PreviewColumn> columns{
        lit_sphere("Conty and Kulla", *facets.model), lit_sphere("SGGX fibers", *fibers.model),
        lit_sphere("half space of them", *deep.model),
        lit_sphere("all orders, solver", solved_table(layer, context))};
    std::vector<SphereLuminance>& now = seen.emplace_back();
    for (const PreviewColumn& c : columns) now.push_back(luminance_of(c));
    Json entry{{"roughness", roughness}};
    const char* const names[] = {"facets", "fibers", "half_space", "all_orders"};
    if (context.table) fmt::print(context.table, "{:>9g}", roughness);
    for (std::size_t k = 0; k < now.size(); ++k) {
      if (context.table)
        fmt::print(context.table, " | {:>9.5f} {:>7.3f}", now[k].mean, now[k].rim / now[k].mean);
      entry[names[k]] = {{"luminance", now[k].mean}, {"rim", now[k].rim}};
    }
    if (context.table) fmt::print(context.table, "\n");
    entry["relative_rmse"] = difference(columns[1], columns[0]).rmse;
    rows.push_back(std::move(entry));
    write_spheres(context, fmt::format("roughness_{:g}", roughness),
                  fmt::format("sheen, roughness {:g}", roughness), columns);
    if (roughness == 0.1 || roughness == 0.4) {
      chart.series.push_back(slice(fmt::format("facets, {:g}", roughness), *facets.model));
      chart.series.push_back(slice(fmt::format("half space, {:g}", roughness), *deep.model));
    }
  }
  context.write("slices", chart);
  const std::vector<SphereLuminance>&low = seen.front(), &high = seen.back();
  context.find(
      "at low roughness Conty and Kulla's facets are very dark",
      fmt::format("from roughness {:g} to {:g} their luminance falls from {:.3f} to {:.3f}",
                  roughnesses.back(), roughnesses.front(), high[0].mean, low[0].mean),
      low[0].mean < 0.5 * high[0].mean);
  context.find("the fibers show a sharp grazing effect even at low roughness",
               fmt::format("their rim grows from {:.2f} to {:.2f} times their mean",
                           high[1].rim / high[1].mean, low[1].rim / low[1].mean),
               low[1].rim > high[1].rim / high[1].mean * low[1].mean);
  context.find(
      "at low roughness the fibers are brighter than the facets",
      fmt::format("luminance {:.3f} of one optical depth of fibers, {:.3f} of a half space, "
                  "{:.3f} of the facets",
                  low[1].mean, low[2].mean, low[0].mean),
      low[1].mean > low[0].mean && low[2].mean > low[0].mean);
  return rows;
}

}  // namespace lamella
