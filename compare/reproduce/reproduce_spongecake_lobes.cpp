#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "analytic/layered/spongecake.h"
#include "compare/drawing/lobe_picture.h"
#include "compare/ensemble/spongecake_accuracy.h"
#include "compare/ensemble/stack_ensemble.h"
#include "compare/fit/least_squares.h"
#include "compare/reproduce/spongecake_lobe_figures.h"
#include "compare/reproduce/spongecake_matrix.h"
#include "compare/request/percent.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr CellGrid kGrid = kMatrixGrid;
// Rows of the matrix whose outgoing lobe is drawn by itself, by their step of mu^2.
constexpr int kShownRows[] = {1, 5};

struct Case {
  std::string name, title;
  Stack stack;
};

Layer layer_of(bool fiber, double roughness, double thickness, Rgb albedo, Rgb f0 = Rgb(1)) {
  return flake_layer(fiber, roughness, fiber ? Direction{1, 0, 0} : Direction{0, 0, 1}, albedo, f0,
                     thickness);
}

std::string text_of(const Layer& layer) {
  return fmt::format("{}_{:g}_{:g}", layer.parameters.choice("shape"),
                     layer.parameters.number("roughness"), layer.thickness);
}

Case case_of(std::vector<Layer> layers) {
  std::string name, title;
  for (const Layer& layer : layers) {
    name += (name.empty() ? "" : "_over_") + text_of(layer);
    title += fmt::format("{}{} of roughness {:g}, thickness {:g}", title.empty() ? "" : ", over ",
                         layer.parameters.choice("shape"), layer.parameters.number("roughness"),
                         layer.thickness);
  }
  return {name, title, Stack{.name = name, .layers = std::move(layers), .substrate = {}}};
}

void write_lobes(ReproductionContext& context, const Case& one, const std::vector<double>& truth,
                 const std::vector<double>& model) {
  const std::vector<MatrixDirection> directions = matrix_directions(kGrid);
  for (const int row : kShownRows)
    for (const bool reflected : {true, false}) {
      const std::size_t k = static_cast<std::size_t>(row) * kGrid.columns();
      const auto from = static_cast<std::ptrdiff_t>((2 * k + (reflected ? 0 : 1)) * kGrid.cells());
      const auto part = [&](const std::vector<double>& all) {
        return std::vector<double>(all.begin() + from, all.begin() + from + kGrid.cells());
      };
      LobePicture picture{
          .grid = kGrid,
          .truth = part(truth),
          .model = part(model),
          .difference = {},
          .z = {},
          .title = fmt::format("{}: {}", one.title, reflected ? "reflected" : "transmitted"),
          .subtitle = fmt::format("theta_i = {:.2f} rad, luminance (Rec. 709)",
                                  std::acos(directions[k].mu)),
          .model_label = "network",
          .mu_i = directions[k].mu,
          .transmitted = !reflected};
      picture.difference = minus(picture.model, picture.truth);
      context.write(fmt::format("{}_{:.0f}_{}", one.name, 100 * std::acos(directions[k].mu),
                                reflected ? "reflect" : "transmit"),
                    [&](PictureFormat format) { return draw_lobe(picture, format); });
    }
}

// A case's truth, and the best two lobes where they can be found.
struct Solved {
  MultipleLobes truth;
  std::unique_ptr<SpongecakeTrial> trial;
  std::optional<SpongecakeLobes> best;
};

Solved solved(const ReproductionContext& context, const Case& one, std::uint64_t walks,
              std::uint64_t seed) {
  Solved s{
      .truth = matrix_truth(one.stack, walks, seed, context.stop), .trial = nullptr, .best = {}};
  context.go_on();
  s.trial = std::make_unique<SpongecakeTrial>(one.stack, s.truth);
  const std::size_t step = context.by_quality(5 * kFitStep, kFitStep, kFitStep);
  if (has_least_squares())
    s.best = SpongecakeTrial(one.stack, thinned(s.truth, step)).best(context.stop);
  return s;
}

// all_orders: pictures of the sum with exact order 1, else of orders 2 and up alone. A draft has
// the first case and the last.
Json lobes_of_cases(ReproductionContext& context, std::vector<Case> cases, bool all_orders) {
  Json rows = Json::array();
  if (context.quality == Quality::draft && cases.size() > 2)
    cases.erase(cases.begin() + 1, cases.end() - 1);
  const std::uint64_t walks = std::max<std::uint64_t>(
      256, context.walks / (cases.size() * static_cast<std::uint64_t>(kGrid.cells())));
  // Fits are of one thread each.
  std::vector<Solved> all(cases.size());
  tbb::parallel_for(std::size_t{0}, cases.size(), [&](std::size_t n) {
    if (!is_set(context.stop)) all[n] = solved(context, cases[n], walks, context.seed + (n << 32));
  });
  if (is_set(context.stop)) return rows;
  if (context.table)
    fmt::print(context.table,
               "{} walks along each of {} incident directions; relative RMSE without noise of "
               "orders 2\nand up (2+), and of all orders without lobes and with the network's\n"
               "{:<36} {:>8} {:>10} {:>9} {:>9} {:>11} {:>9}\n",
               walks, kGrid.cells(), "layers: kind, roughness, thickness", "2+ share", "2+ network",
               "2+ fit", "all none", "all network", "noise");
  for (std::size_t n = 0; n < cases.size(); ++n) {
    if (is_set(context.stop)) return rows;
    const Case& one = cases[n];
    const SpongecakeTrial& trial = *all[n].trial;
    const std::optional<SpongecakeLobes>& best = all[n].best;
    const double noise = all[n].truth.relative_noise();
    const SpongecakeLobes predicted = predicted_lobes(one.stack);
    const LobeErrors none = trial.errors_of(std::nullopt), network = trial.errors_of(predicted);
    const double fit = best ? trial.errors_of(*best).multiple : 0;
    if (context.table)
      fmt::print(context.table, "{:<36} {:>8} {:>10} {:>9} {:>9} {:>11} {:>9}\n", one.name,
                 percent_cell(trial.multiple_share()), percent_cell(network.multiple),
                 best ? percent_cell(fit) : "-", percent_cell(none.all), percent_cell(network.all),
                 percent_cell(noise));
    Json row{{"stack", one.name},
             {"multiple_share", trial.multiple_share()},
             {"noise", noise},
             {"network", {{"multiple", network.multiple}, {"all", network.all}}},
             {"nothing", {{"multiple", none.multiple}, {"all", none.all}}}};
    if (best) row["fit"] = {{"multiple", fit}};
    rows.push_back(std::move(row));

    const LobeMatrix matrix = spongecake_matrix(trial, predicted, best, all_orders, one.title);
    context.write(one.name + "_matrix",
                  [&](PictureFormat format) { return draw_lobe_matrix(matrix, format); });
    write_lobes(context, one, matrix.panels[0].values, matrix.panels[1].values);
  }
  return rows;
}

// The rows of lobes_of_cases, and that the lobes are close: a tenth of f, root mean square.
Json close_lobes_of_cases(ReproductionContext& context, const std::vector<Case>& cases,
                          bool all_orders) {
  Json rows = lobes_of_cases(context, cases, all_orders);
  if (rows.empty()) return rows;
  double without = 0, with = 0;
  for (const Json& row : rows) {
    without = std::max(without, row["nothing"]["all"].get<double>());
    with = std::max(with, row["network"]["all"].get<double>());
  }
  context.find("with two further lobes SpongeCake comes close to the reference",
               fmt::format("all orders are off by at most {} (relative RMSE), without lobes by {}",
                           percent_text(with), percent_text(without)),
               with < 0.1 && with < without);
  return rows;
}

const Rgb kWarm{0.9, 0.7, 0.5};

std::vector<Case> single_layers() {
  return {case_of({layer_of(false, 0.3, 1, kWarm)}), case_of({layer_of(false, 0.8, 5, kWarm)}),
          case_of({layer_of(true, 0.2, 1, kWarm)}), case_of({layer_of(true, 0.8, 5, kWarm)})};
}

// Those of its table 2 and figures 7, 17 that have two layers.
std::vector<Case> double_layers() {
  const Rgb window{0.9, 0.9, 0.7}, shade{0.7, 0.1, 0.1};
  return {case_of({layer_of(true, 0.1, 1, window), layer_of(true, 1, 1, window)}),
          case_of({layer_of(true, 0.1, 1, shade), layer_of(false, 0.8, 5, shade)}),
          case_of({layer_of(true, 0.5, 1, kWarm), layer_of(false, 0.8, 5, kWarm)}),
          case_of({layer_of(false, 0.5, 0.5, kWarm), layer_of(false, 0.9, 2, kWarm)})};
}

Json figure_8(ReproductionContext& context) {
  return close_lobes_of_cases(context, single_layers(), true);
}
Json figure_10(ReproductionContext& context) {
  return close_lobes_of_cases(context, single_layers(), false);
}
Json figure_11(ReproductionContext& context) {
  return close_lobes_of_cases(context, double_layers(), true);
}
Json figure_13(ReproductionContext& context) {
  return close_lobes_of_cases(context, double_layers(), false);
}

Json figure_9(ReproductionContext& context) {
  std::vector<Case> cases;
  for (const bool fiber : {false, true})
    for (const double thickness : {0.5, 2.0, 8.0})
      for (const double roughness : {0.1, 0.5, 1.0})
        cases.push_back(case_of({layer_of(fiber, roughness, thickness, kWarm)}));
  return close_lobes_of_cases(context, cases, false);
}

Json figure_12(ReproductionContext& context) {
  std::vector<Case> cases;
  for (const double thickness : {0.5, 2.0, 8.0})
    for (const double roughness : {0.1, 0.5, 1.0})
      cases.push_back(case_of(
          {layer_of(false, 0.5, 0.5, kWarm), layer_of(false, roughness, thickness, kWarm)}));
  return close_lobes_of_cases(context, cases, false);
}

// Rough copper: mirrors with its reflectance at normal incidence.
Json figure_20(ReproductionContext& context) {
  const Rgb copper{0.955, 0.638, 0.538};
  std::vector<Case> cases;
  for (const double roughness : {0.3, 0.6, 1.0})
    cases.push_back(case_of({layer_of(false, roughness, 10, Rgb(1), copper)}));
  return close_lobes_of_cases(context, cases, true);
}

Json figure_22(ReproductionContext& context) {
  std::vector<Case> cases;
  for (const double roughness : {0.05, 0.1, 0.3, 1.0})
    cases.push_back(case_of({layer_of(true, roughness, 1, Rgb(0.9))}));
  Json rows = lobes_of_cases(context, cases, false);
  if (rows.empty()) return rows;
  const double little = rows.front()["multiple_share"], much = rows.back()["multiple_share"];
  context.find("with fibers of low roughness the proportion of multiple scattering is low",
               fmt::format("orders 2 and up are {} of the scattered light at roughness 0.05, {} at "
                           "1 (albedo 0.9, thickness 1)",
                           percent_text(little), percent_text(much)),
               little < 0.5 * much);
  if (!has_least_squares()) return rows;
  const double sharp = rows.front()["fit"]["multiple"], smooth = rows.back()["fit"]["multiple"];
  context.find(
      "two lobes cannot describe multiple scattering among fibers of low roughness",
      fmt::format("the best fit of orders 2 and up is off by {} at roughness 0.05, by {} at 1",
                  percent_text(sharp), percent_text(smooth)),
      sharp > 2 * smooth);
  return rows;
}

// Energy of f over cells of equal projected solid angle, both sides.
double energy_of(const std::vector<Rgb>& values) {
  double sum = 0;
  for (const Rgb& f : values) sum += luminance(f);
  return sum * kGrid.projected_solid_angle();
}

Json figure_21(ReproductionContext& context) {
  const Case one = case_of({layer_of(false, 0.5, 0.5, Rgb(1)), layer_of(false, 0.9, 2, Rgb(1))});
  const SpongecakeLobes predicted = predicted_lobes(one.stack);
  std::optional<SpongecakeLobes> best;
  if (has_least_squares()) {
    const MultipleLobes truth = matrix_truth(one.stack, 8192, context.seed, context.stop);
    context.go_on();
    best = SpongecakeTrial(one.stack, thinned(truth)).best(context.stop);
  }
  Json rows = Json::array();
  const double angles[] = {0, 20, 40, 60, 70, 80};
  const std::uint64_t walks = std::max<std::uint64_t>(256, context.walks / std::size(angles));
  if (context.table)
    fmt::print(context.table,
               "a white stack, {}: light that leaves it, of 1, {} walks per direction\n"
               "{:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
               one.name, walks, "theta_i", "delta", "+ single", "+ network", "+ fit", "+ truth",
               "+-");
  Chart chart{.title = "White furnace of two layers",
              .subtitle = "light that leaves, as a share of the light that arrives",
              .x_label = "\u03b8_i [degrees]",
              .y_label = "energy",
              .series = {{.label = "delta", .x = {}, .y = {}},
                         {.label = "and single", .x = {}, .y = {}},
                         {.label = "and network", .x = {}, .y = {}},
                         {.label = "and truth", .x = {}, .y = {}}}};
  for (std::size_t k = 0; k < std::size(angles) && !is_set(context.stop); ++k) {
    const Direction wi = direction_from_degrees(angles[k], 0);
    const MultipleLobes lobes =
        multiple_lobes(one.stack, {wi}, kGrid, walks, context.seed + (k << 8), context.stop);
    if (is_set(context.stop)) break;
    const SpongecakeTrial trial(one.stack, lobes);
    const double delta = one.stack.uncollided(wi), single = delta + energy_of(trial.single());
    const double network = single + energy_of(trial.values(predicted));
    const double fit = best ? single + energy_of(trial.values(*best)) : 0;
    const double truth = single + energy_of(trial.truth());
    double variance = 0;
    for (std::size_t c = 0; c < lobes.variance.size(); c += 3)
      variance += static_cast<double>(lobes.variance[c]);
    const double error = std::sqrt(variance) * kGrid.projected_solid_angle();
    const double values[] = {delta, single, network, truth};
    if (context.table)
      fmt::print(context.table, "{:>7g} {:>9.4f} {:>9.4f} {:>9.4f} {:>9} {:>9.4f} {:>9.1e}\n",
                 angles[k], delta, single, network, best ? fmt::format("{:.4f}", fit) : "-", truth,
                 error);
    for (std::size_t s = 0; s < chart.series.size(); ++s) {
      chart.series[s].x.push_back(angles[k]);
      chart.series[s].y.push_back(values[s]);
    }
    rows.push_back({{"theta_i", angles[k]},
                    {"delta", delta},
                    {"single", single},
                    {"network", network},
                    {"truth", truth},
                    {"standard_error", error}});
    if (best) rows.back()["fit"] = fit;
  }
  context.write("furnace", chart);
  if (is_set(context.stop)) return rows;
  double truth_off = 0, lobes_off = 0, most_single = 0;
  for (const Json& row : rows) {
    const double truth = row["truth"];
    truth_off = std::max(truth_off, std::abs(truth - 1) / row["standard_error"].get<double>());
    lobes_off = std::max(lobes_off, std::abs(row["network"].get<double>() - truth));
    most_single = std::max(most_single, row["single"].get<double>());
  }
  context.find("the reference keeps the energy of a white stack",
               fmt::format("the truth is within {:.1f} standard errors of 1", truth_off),
               truth_off < 5);
  context.find(
      "single scattering loses much of the energy and the lobes bring most of it back",
      fmt::format("single scattering leaves at most {:.3f}; with the network's lobes the energy is "
                  "within {:.3f} of the truth's",
                  most_single, lobes_off),
      lobes_off < 1 - most_single);
  return rows;
}

}  // namespace

const std::vector<Reproduction>& spongecake_lobe_figures() {
  const std::string source = "Wang et al. 2022, SpongeCake, figure ";
  constexpr std::uint64_t kWalks = 64000000;
  static const std::vector<Reproduction> list{
      {"spongecake_figure_8", "one layer, all orders: truth, SpongeCake with its network, fit",
       source + "8, as lobes; the layers are ours", kWalks, false, figure_8},
      {"spongecake_figure_9", "one layer, orders 2 and up, over thickness and roughness",
       source + "9, as lobes; the layers are ours", 2 * kWalks, false, figure_9},
      {"spongecake_figure_10", "one layer, orders 2 and up: incident times outgoing, and lobes",
       source + "10; the layers are ours", kWalks, false, figure_10},
      {"spongecake_figure_11",
       "two layers, all orders: those of table 2 and of figures 7 and 17; network, fit",
       source + "11, as lobes", kWalks, false, figure_11},
      {"spongecake_figure_12",
       "two layers, orders 2 and up, over thickness and roughness of the lower one",
       source + "12, as lobes; the layers are ours", 2 * kWalks, false, figure_12},
      {"spongecake_figure_13", "two layers, orders 2 and up: incident times outgoing, and lobes",
       source + "13; the layers are those of figure 11", kWalks, false, figure_13},
      {"spongecake_figure_20", "rough copper as a layer of SGGX mirrors: all orders",
       source + "20, as lobes", kWalks, false, figure_20},
      {"spongecake_figure_21", "white furnace of two layers: delta, single, network, fit, truth",
       source + "21; the layers are those of figure 7", 1000000, false, figure_21},
      {"spongecake_figure_22", "fibers of low roughness, which two lobes cannot describe",
       source + "22; the layers are ours", kWalks, false, figure_22},
  };
  return list;
}

}  // namespace lamella
