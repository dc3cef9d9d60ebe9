#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/half_space/lambert_sphere_formula.h"
#include "analytic/half_space/lambert_sphere_models.h"
#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/map_sheet.h"
#include "compare/reproduce/number_rows.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

DeterministicField solved(double albedo, const std::vector<double>& mu,
                          const ReproductionContext& context) {
  DeterministicOptions options{.tolerance = context.by_quality(1e-3, 1e-5, 1e-7), .max_nodes = 64};
  options.isa = isa_from_text("auto");
  options.stop = context.stop;
  const Stack stack = figure_stack(
      "spheres",
      fmt::format("[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = {}\nthickness = inf\n",
                  albedo));
  return solve_deterministic(stack, options).field(mu, mu);
}

std::vector<double> middles(int side) {
  std::vector<double> mu;
  for (int k = 0; k < side; ++k) mu.push_back((k + 0.5) / side);
  return mu;
}

double root_mean_square(const std::vector<double>& map) {
  double sum = 0;
  for (const double v : map) sum += v * v;
  return std::sqrt(sum / static_cast<double>(map.size()));
}

// A map of g(i, o), the highest incoming cosine first.
template <class G>
std::vector<double> map_of(std::size_t side, const G& g) {
  std::vector<double> map(side * side);
  for (std::size_t i = 0; i < side; ++i)
    for (std::size_t o = 0; o < side; ++o) map[(side - 1 - i) * side + o] = g(i, o);
  return map;
}

// Eq. 36 with the fits of eqs. 37 to 42.
double fitted_mean(const AnalyticLambertSphere::Channel& k, double x, double y) {
  return 1 / (2 * kPi) * k.h0(std::log(x)) * k.h0(std::log(y)) / (x + y) *
         (k.a + (k.b + k.d * x * y) * (x + y) + (k.c + k.e * x * y) * x * y +
          k.f * (x * x + y * y));
}

}  // namespace

Json reproduce_lambert_sphere_figure_3(ReproductionContext& context) {
  const std::vector<double> mu = middles(context.by_quality(6, 16, 32));
  const std::vector<double> albedos = context.quality == Quality::draft
                                          ? std::vector<double>{0.5, 1}
                                          : std::vector<double>{0.3, 0.5, 0.7, 0.9, 0.99, 1};
  MapSheet sheet{
      .title = "Fourier modes of multiple scattering, f_m cos \u03b8_o",
      .subtitle =
          "f = f\u2070 + 2 f\u00b9 cos \u03c6 + 2 f\u00b2 cos 2\u03c6; u_o to the right, u_i "
          "upwards; columns: albedo",
      .columns = {},
      .rows = {{.label = "f\u2070", .maps = {}},
               {.label = "f\u00b9", .maps = {}, .is_signed = true},
               {.label = "f\u00b2", .maps = {}, .is_signed = true}},
      .side = static_cast<int>(mu.size())};
  NumberRows rows(context, {{"albedo", "g"},
                            {"mode_0", ".5f", "mode 0"},
                            {"mode_1", ".5f", "mode 1"},
                            {"mode_2", ".5f", "mode 2"},
                            {"share_1", ".5f", "1 / 0"},
                            {"share_2", ".5f", "2 / 0"},
                            {"share_of_all", ".5f", "2 / all"}});
  rows.header(
      "root mean squares of f_m cos theta_o, orders 2 and more, by the solver; the last: of mode 2 "
      "over mode 0\nof all orders");
  double first = 0, second = 0;
  for (const double c : albedos) {
    if (is_set(context.stop)) return rows.rows();
    const DeterministicField field = solved(c, mu, context);
    double rms[3];
    sheet.columns.push_back(fmt::format("{:g}", c));
    for (int m = 0; m < 3; ++m) {
      std::vector<double> map = map_of(mu.size(), [&](std::size_t i, std::size_t o) {
        return m < field.modes(0) ? (m % 2 ? -1 : 1) * field.mode(0, 4, m, i, o) * mu[o] : 0;
      });
      rms[m] = root_mean_square(map);
      sheet.rows[m].maps.push_back(std::move(map));
    }
    const double all = root_mean_square(map_of(
        mu.size(), [&](std::size_t i, std::size_t o) { return field.mean(0, i, o) * mu[o]; }));
    rows.add({c, rms[0], rms[1], rms[2], rms[1] / rms[0], rms[2] / rms[0], rms[2] / all});
    first = std::max(first, rms[1] / rms[0]);
    second = std::max(second, rms[2] / rms[0]);
  }
  context.write("modes", [&](PictureFormat format) { return draw_map_sheet(sheet, format); });
  context.find("mode 2 of multiple scattering is very weak beside the multiply scattered energy",
               fmt::format("its root mean square is at most {:.2f} % of mode 0's", 100 * second),
               second < 0.01);
  context.find("mode 1 is not negligible",
               fmt::format("its root mean square is up to {:.1f} % of mode 0's", 100 * first),
               first > 0.01 && first > 5 * second);
  return rows.rows();
}

Json reproduce_lambert_sphere_figure_5(ReproductionContext& context) {
  const std::vector<double> mu = middles(context.by_quality(6, 16, 32));
  const std::vector<double> albedos =
      context.quality == Quality::draft
          ? std::vector<double>{0.5, 1}
          : std::vector<double>{0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1};
  MapSheet sheet{.title = "Mode 0 of the BRDF, f\u2070 cos \u03b8_o",
                 .subtitle = "u_o to the right, u_i upwards; columns: albedo; fit: eqs. 36 to 42",
                 .columns = {},
                 .rows = {{.label = "solver", .maps = {}},
                          {.label = "fit", .maps = {}, .is_signed = false, .same_scale = true},
                          {.label = "fit \u2212 solver", .maps = {}, .is_signed = true}},
                 .side = static_cast<int>(mu.size())};
  Chart chart{.title = "Relative error of the fitted mode 0 over the albedo",
              .subtitle =
                  "largest over all pairs of cosines, and root mean square over root mean "
                  "square",
              .x_label = "albedo c",
              .y_label = "relative error",
              .series = {{.label = "largest, from the exact three-term form", .x = {}, .y = {}},
                         {.label = "rms, from the exact three-term form", .x = {}, .y = {}},
                         {.label = "largest, from the solver", .x = {}, .y = {}},
                         {.label = "rms, from the solver", .x = {}, .y = {}}}};
  NumberRows rows(context, {{"albedo", "g"},
                            {"largest_three_term", ".5f", "largest"},
                            {"rms_three_term", ".5f", "rms"},
                            {"largest_solver", ".5f", "largest s."},
                            {"rms_solver", ".5f", "rms s."},
                            {"h0_error", ".5f", "H0"}});
  rows.header(
      "relative errors of eqs. 36 to 42 from the exact three-term form, and from the solver (s.), "
      "whose "
      "phase\nfunction is exact; of the fitted H0, mu from 0.01");
  double largest = 0, from_solver = 0, h0 = 0;
  for (const double c : albedos) {
    if (is_set(context.stop)) return rows.rows();
    const DeterministicField field = solved(c, mu, context);
    const AnalyticLambertSphere formula = lambert_sphere_formula(Rgb(c));
    const ThreeTermHalfSpace exact(lambert_sphere_phase_terms(c));
    const auto fit = [&](std::size_t i, std::size_t o) {
      return fitted_mean(formula.channels[0], mu[i], mu[o]);
    };
    double most[2] = {0, 0}, square[2] = {0, 0}, scale[2] = {0, 0};
    for (std::size_t i = 0; i < mu.size(); ++i)
      for (std::size_t o = 0; o < mu.size(); ++o) {
        const double truths[] = {exact.mode(0, mu[i], mu[o]), field.mean(0, i, o)};
        for (int k = 0; k < 2; ++k) {
          const double d = fit(i, o) - truths[k];
          most[k] = std::max(most[k], std::abs(d / truths[k]));
          square[k] += d * d;
          scale[k] += truths[k] * truths[k];
        }
      }
    double h = 0;
    for (int k = 1; k <= 100; ++k)
      h = std::max(h, std::abs(lambert_sphere_h0(k / 100.0, c) / exact.h(0)(k / 100.0) - 1));
    rows.add(
        {c, most[0], std::sqrt(square[0] / scale[0]), most[1], std::sqrt(square[1] / scale[1]), h});
    for (int k = 0; k < 2; ++k) {
      chart.series[2 * k].x.push_back(c);
      chart.series[2 * k].y.push_back(most[k]);
      chart.series[2 * k + 1].x.push_back(c);
      chart.series[2 * k + 1].y.push_back(std::sqrt(square[k] / scale[k]));
    }
    largest = std::max(largest, most[0]);
    from_solver = std::max(from_solver, std::sqrt(square[1] / scale[1]));
    h0 = std::max(h0, h);
    sheet.columns.push_back(fmt::format("{:g}", c));
    auto truth = map_of(mu.size(),
                        [&](std::size_t i, std::size_t o) { return field.mean(0, i, o) * mu[o]; });
    auto model = map_of(mu.size(), [&](std::size_t i, std::size_t o) { return fit(i, o) * mu[o]; });
    std::vector<double> error(truth.size());
    for (std::size_t k = 0; k < error.size(); ++k) error[k] = model[k] - truth[k];
    sheet.rows[0].maps.push_back(std::move(truth));
    sheet.rows[1].maps.push_back(std::move(model));
    sheet.rows[2].maps.push_back(std::move(error));
  }
  context.write("maps", [&](PictureFormat format) { return draw_map_sheet(sheet, format); });
  context.write("error", chart);
  context.find("the fitted H0 has a relative error of less than 1 %",
               fmt::format("{:.2f} % at most", 100 * h0), h0 < 0.01);
  context.find("the fit of mode 0 is close to the reference at every albedo",
               fmt::format("within {:.1f} % of the exact three-term form; root mean square {:.1f} "
                           "% from the solver",
                           100 * largest, 100 * from_solver),
               largest < 0.05 && from_solver < 0.05);
  return rows.rows();
}

}  // namespace lamella
