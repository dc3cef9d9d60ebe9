#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/layered/spongecake.h"
#include "compare/drawing/lobe_picture.h"
#include "compare/ensemble/spongecake_accuracy.h"
#include "compare/ensemble/stack_ensemble.h"
#include "compare/fit/least_squares.h"
#include "compare/reproduce/lobe_matrix.h"
#include "compare/reproduce/spongecake_lobe_figures.h"
#include "compare/request/percent.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr CellGrid kGrid{8, 16, false};
constexpr int kFitDirections = 8;
// Rows of the matrix whose outgoing lobe is drawn by itself, by their step of mu^2.
constexpr int kShownRows[] = {1, 5};

struct Case {
  std::string name;
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
  std::string name;
  for (const Layer& layer : layers) name += (name.empty() ? "" : "_over_") + text_of(layer);
  return {name, Stack{.name = name, .layers = std::move(layers), .substrate = {}}};
}

// The truth along the directions of a matrix, one task per direction.
MultipleLobes matrix_truth(const Stack& stack, std::uint64_t walks, std::uint64_t seed) {
  const std::vector<MatrixDirection> directions = matrix_directions(kGrid);
  std::vector<MultipleLobes> rows(directions.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t k) {
    rows[k] = multiple_lobes(stack, {direction_from_mu_phi(directions[k].mu, directions[k].phi)},
                             kGrid, walks, seed + (k << 8));
  });
  MultipleLobes all{.grid = kGrid, .incident = {}, .walks = walks, .value = {}, .variance = {}};
  for (const MultipleLobes& row : rows) {
    all.incident.push_back(row.incident.front());
    all.value.insert(all.value.end(), row.value.begin(), row.value.end());
    all.variance.insert(all.variance.end(), row.variance.begin(), row.variance.end());
  }
  return all;
}

// Every n-th direction of a truth, of other azimuths at every step of mu^2.
MultipleLobes thinned(const MultipleLobes& all) {
  MultipleLobes some{
      .grid = all.grid, .incident = {}, .walks = all.walks, .value = {}, .variance = {}};
  const std::size_t numbers = 3 * all.cells_per_direction();
  const std::size_t step = all.incident.size() / kFitDirections + 3;
  for (std::size_t k = 0; k < all.incident.size(); k += step) {
    some.incident.push_back(all.incident[k]);
    const auto from = static_cast<std::ptrdiff_t>(k * numbers);
    const auto to = static_cast<std::ptrdiff_t>((k + 1) * numbers);
    some.value.insert(some.value.end(), all.value.begin() + from, all.value.begin() + to);
    some.variance.insert(some.variance.end(), all.variance.begin() + from,
                         all.variance.begin() + to);
  }
  return some;
}

std::vector<double> luminances(const std::vector<Rgb>& values, const std::vector<Rgb>& more) {
  std::vector<double> out;
  for (std::size_t k = 0; k < values.size(); ++k)
    out.push_back(luminance(more.empty() ? values[k] : values[k] + more[k]));
  return out;
}

std::vector<double> minus(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out;
  for (std::size_t k = 0; k < a.size(); ++k) out.push_back(a[k] - b[k]);
  return out;
}

void write_lobes(ReproductionContext& context, const std::string& name,
                 const std::vector<double>& truth, const std::vector<double>& model) {
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
          .title = fmt::format("{}, {}", name, reflected ? "reflected" : "transmitted"),
          .subtitle = fmt::format("theta_i = {:.2f} rad, luminance (Rec. 709)",
                                  std::acos(directions[k].mu)),
          .model_label = "network",
          .mu_i = directions[k].mu,
          .transmitted = !reflected};
      picture.difference = minus(picture.model, picture.truth);
      context.write(fmt::format("{}_{:.0f}_{}", name, 100 * std::acos(directions[k].mu),
                                reflected ? "reflect" : "transmit"),
                    [&](PictureFormat format) { return draw_lobe(picture, format); });
    }
}

// all_orders: pictures of the sum with exact order 1, else of orders 2 and up alone.
Json lobes_of_cases(ReproductionContext& context, const std::vector<Case>& cases, bool all_orders) {
  Json rows = Json::array();
  const std::uint64_t walks = std::max<std::uint64_t>(
      256, context.walks / (cases.size() * static_cast<std::uint64_t>(kGrid.cells())));
  if (context.table)
    fmt::print(context.table,
               "{} walks along each of {} incident directions; relative RMSE without noise of "
               "orders 2 and up (2+),\nand of all orders without lobes and with them (the "
               "network's for one layer, else the fit)\n"
               "{:<36} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
               walks, kGrid.cells(), "layers: kind, roughness, thickness", "2+ share", "2+ lobes",
               "2+ fit", "all none", "all lobes", "noise");
  double most_without = 0, most_with = 0;
  for (std::size_t n = 0; n < cases.size() && !is_set(context.stop); ++n) {
    const Case& one = cases[n];
    const MultipleLobes lobes = matrix_truth(one.stack, walks, context.seed + (n << 32));
    const SpongecakeTrial trial(one.stack, lobes);
    std::optional<SpongecakeLobes> best;
    if (has_least_squares()) best = SpongecakeTrial(one.stack, thinned(lobes)).best();
    // Where the network does not apply SpongeCake takes the fit.
    const SpongecakeLobes predicted =
        best && !why_no_network(one.stack).empty() ? *best : predicted_lobes(one.stack);
    const LobeErrors none = trial.errors_of(std::nullopt), network = trial.errors_of(predicted);
    const double fit = best ? trial.errors_of(*best).multiple : 0;
    most_without = std::max(most_without, none.all);
    most_with = std::max(most_with, network.all);
    if (context.table)
      fmt::print(context.table, "{:<36} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", one.name,
                 percent_cell(trial.multiple_share()), percent_cell(network.multiple),
                 best ? percent_cell(fit) : "-", percent_cell(none.all), percent_cell(network.all),
                 percent_cell(lobes.relative_noise()));
    Json row{{"stack", one.name},
             {"multiple_share", trial.multiple_share()},
             {"noise", lobes.relative_noise()},
             {"network", {{"multiple", network.multiple}, {"all", network.all}}},
             {"nothing", {{"multiple", none.multiple}, {"all", none.all}}}};
    if (best) row["fit"] = {{"multiple", fit}};
    rows.push_back(std::move(row));

    const std::vector<Rgb> more = all_orders ? trial.single() : std::vector<Rgb>();
    const std::vector<double> truth = luminances(trial.truth(), more);
    const std::vector<double> model = luminances(trial.values(predicted), more);
    LobeMatrix matrix{.grid = kGrid, .panels = {}, .title = one.name, .subtitle = {}};
    matrix.subtitle = fmt::format(
        "{}: rows are incident directions, columns outgoing cells; f "
        "[1/sr], luminance",
        all_orders ? "all orders" : "orders 2 and up");
    matrix.panels.push_back({"truth", truth, false});
    matrix.panels.push_back({"network", model, false});
    if (best) matrix.panels.push_back({"best fit", luminances(trial.values(*best), more), false});
    matrix.panels.push_back({"network - truth", minus(model, truth), true});
    context.write(one.name + "_matrix",
                  [&](PictureFormat format) { return draw_lobe_matrix(matrix, format); });
    write_lobes(context, one.name, truth, model);
  }
  // Close: a tenth of f, root mean square.
  if (!is_set(context.stop))
    context.find(
        "with two further lobes SpongeCake comes close to the reference",
        fmt::format("all orders are off by at most {} (relative RMSE), without lobes by {}",
                    percent_cell(most_with), percent_cell(most_without)),
        most_with < 0.1 && most_with < most_without);
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
  return lobes_of_cases(context, single_layers(), true);
}
Json figure_10(ReproductionContext& context) {
  return lobes_of_cases(context, single_layers(), false);
}
Json figure_11(ReproductionContext& context) {
  return lobes_of_cases(context, double_layers(), true);
}
Json figure_13(ReproductionContext& context) {
  return lobes_of_cases(context, double_layers(), false);
}

Json figure_9(ReproductionContext& context) {
  std::vector<Case> cases;
  for (const bool fiber : {false, true})
    for (const double thickness : {0.5, 2.0, 8.0})
      for (const double roughness : {0.1, 0.5, 1.0})
        cases.push_back(case_of({layer_of(fiber, roughness, thickness, kWarm)}));
  return lobes_of_cases(context, cases, false);
}

Json figure_12(ReproductionContext& context) {
  std::vector<Case> cases;
  for (const double thickness : {0.5, 2.0, 8.0})
    for (const double roughness : {0.1, 0.5, 1.0})
      cases.push_back(case_of(
          {layer_of(false, 0.5, 0.5, kWarm), layer_of(false, roughness, thickness, kWarm)}));
  return lobes_of_cases(context, cases, false);
}

// Rough copper: mirrors with its reflectance at normal incidence.
Json figure_20(ReproductionContext& context) {
  const Rgb copper{0.955, 0.638, 0.538};
  std::vector<Case> cases;
  for (const double roughness : {0.3, 0.6, 1.0})
    cases.push_back(case_of({layer_of(false, roughness, 10, Rgb(1), copper)}));
  return lobes_of_cases(context, cases, true);
}

Json figure_22(ReproductionContext& context) {
  std::vector<Case> cases;
  for (const double roughness : {0.05, 0.1, 0.3, 1.0})
    cases.push_back(case_of({layer_of(true, roughness, 1, Rgb(0.9))}));
  Json rows = lobes_of_cases(context, cases, false);
  if (is_set(context.stop) || !has_least_squares()) return rows;
  const double sharp = rows.front()["fit"]["multiple"], smooth = rows.back()["fit"]["multiple"];
  context.find(
      "two lobes cannot describe multiple scattering among fibers of low roughness",
      fmt::format("the best fit of orders 2 and up is off by {} at roughness 0.05, by {} at 1",
                  percent_cell(sharp), percent_cell(smooth)),
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
  require_least_squares();
  const SpongecakeLobes predicted =
      SpongecakeTrial(one.stack, thinned(matrix_truth(one.stack, 8192, context.seed))).best();
  Json rows = Json::array();
  const double angles[] = {0, 20, 40, 60, 70, 80};
  const std::uint64_t walks = std::max<std::uint64_t>(256, context.walks / std::size(angles));
  if (context.table)
    fmt::print(context.table,
               "a white stack, {}: light that leaves it, of 1, {} walks per direction\n"
               "{:>7} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
               one.name, walks, "theta_i", "delta", "+ single", "+ lobes", "+ truth", "+-");
  Chart chart{.title = "White furnace of two layers",
              .subtitle = "light that leaves, as a share of the light that arrives",
              .x_label = "\u03b8_i [degrees]",
              .y_label = "energy",
              .series = {{.label = "delta", .x = {}, .y = {}},
                         {.label = "and single", .x = {}, .y = {}},
                         {.label = "and lobes", .x = {}, .y = {}},
                         {.label = "and truth", .x = {}, .y = {}}}};
  for (std::size_t k = 0; k < std::size(angles) && !is_set(context.stop); ++k) {
    const Direction wi = direction_from_degrees(angles[k], 0);
    const MultipleLobes lobes =
        multiple_lobes(one.stack, {wi}, kGrid, walks, context.seed + (k << 8));
    const SpongecakeTrial trial(one.stack, lobes);
    const double delta = one.stack.uncollided(wi), single = delta + energy_of(trial.single());
    const double network = single + energy_of(trial.values(predicted));
    const double truth = single + energy_of(trial.truth());
    double variance = 0;
    for (std::size_t c = 0; c < lobes.variance.size(); c += 3)
      variance += static_cast<double>(lobes.variance[c]);
    const double error = std::sqrt(variance) * kGrid.projected_solid_angle();
    const double values[] = {delta, single, network, truth};
    if (context.table)
      fmt::print(context.table, "{:>7g} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.1e}\n", angles[k],
                 delta, single, network, truth, error);
    for (std::size_t s = 0; s < chart.series.size(); ++s) {
      chart.series[s].x.push_back(angles[k]);
      chart.series[s].y.push_back(values[s]);
    }
    rows.push_back({{"theta_i", angles[k]},
                    {"delta", delta},
                    {"single", single},
                    {"lobes", network},
                    {"truth", truth},
                    {"standard_error", error}});
  }
  context.write("furnace", chart);
  if (is_set(context.stop)) return rows;
  double truth_off = 0, lobes_off = 0, most_single = 0;
  for (const Json& row : rows) {
    const double truth = row["truth"];
    truth_off = std::max(truth_off, std::abs(truth - 1) / row["standard_error"].get<double>());
    lobes_off = std::max(lobes_off, std::abs(row["lobes"].get<double>() - truth));
    most_single = std::max(most_single, row["single"].get<double>());
  }
  context.find("the reference keeps the energy of a white stack",
               fmt::format("the truth is within {:.1f} standard errors of 1", truth_off),
               truth_off < 5);
  context.find(
      "single scattering loses much of the energy and the lobes bring most of it back",
      fmt::format("single scattering leaves at most {:.3f}; with lobes the energy is within "
                  "{:.3f} of the truth's",
                  most_single, lobes_off),
      lobes_off < 1 - most_single);
  return rows;
}

}  // namespace

const std::vector<Reproduction>& spongecake_lobe_figures() {
  const std::string source = "Wang et al. 2022, SpongeCake, figure ";
  constexpr std::uint64_t kWalks = 16000000;
  static const std::vector<Reproduction> list{
      {"spongecake_figure_8", "one layer, all orders: truth, SpongeCake with its network, fit",
       source + "8, as lobes; the layers are ours", kWalks, false, figure_8},
      {"spongecake_figure_9", "one layer, orders 2 and up, over thickness and roughness",
       source + "9, as lobes; the layers are ours", 2 * kWalks, false, figure_9},
      {"spongecake_figure_10", "one layer, orders 2 and up: incident times outgoing, and lobes",
       source + "10; the layers are ours", kWalks, false, figure_10},
      {"spongecake_figure_11", "two layers, all orders: those of table 2 and of figures 7 and 17",
       source + "11, as lobes", kWalks, false, figure_11},
      {"spongecake_figure_12",
       "two layers, orders 2 and up, over thickness and roughness of the lower one",
       source + "12, as lobes; the layers are ours", 2 * kWalks, false, figure_12},
      {"spongecake_figure_13", "two layers, orders 2 and up: incident times outgoing, and lobes",
       source + "13; the layers are those of figure 11", kWalks, false, figure_13},
      {"spongecake_figure_20", "rough copper as a layer of SGGX mirrors: all orders",
       source + "20, as lobes", kWalks, false, figure_20},
      {"spongecake_figure_21", "white furnace of two layers: delta, single, fitted lobes, truth",
       source + "21; the layers are those of figure 7", 1000000, false, figure_21},
      {"spongecake_figure_22", "fibers of low roughness, which two lobes cannot describe",
       source + "22; the layers are ours", kWalks, false, figure_22},
  };
  return list;
}

}  // namespace lamella
