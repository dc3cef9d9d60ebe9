#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/half_space/lambert_sphere_models.h"
#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/number_rows.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Constants by name: the exact ones, and their fits, of one albedo.
struct Constant {
  const char* name;
  double exact, fit;
};

// Draws the constants over the albedo and gives the largest distance of each from its fit.
std::vector<double> draw_constants(ReproductionContext& context, NumberRows& rows,
                                   const std::string& picture, const std::string& title,
                                   std::vector<Constant> (*constants)(double albedo)) {
  Chart chart{.title = title,
              .subtitle = "dots: exact; lines: fits of the paper",
              .x_label = "albedo c",
              .y_label = "constant",
              .series = {}};
  for (const Constant& c : constants(0.5)) {
    chart.series.push_back({.label = c.name, .x = {}, .y = {}});
    chart.series.push_back({.label = "", .x = {}, .y = {}, .dots = true, .same_color = true});
  }
  std::vector<double> largest(chart.series.size() / 2);
  const int steps = context.by_quality(10, 50, 200);
  for (int k = 1; k <= steps; ++k) {
    const double albedo = k / static_cast<double>(steps);
    const std::vector<Constant> now = constants(albedo);
    std::vector<NumberRows::Value> row{albedo};
    for (std::size_t n = 0; n < now.size(); ++n) {
      chart.series[2 * n].x.push_back(albedo);
      chart.series[2 * n].y.push_back(now[n].fit);
      if (k % std::max(1, steps / 25) == 0) {
        chart.series[2 * n + 1].x.push_back(albedo);
        chart.series[2 * n + 1].y.push_back(now[n].exact);
      }
      largest[n] = std::max(largest[n], std::abs(now[n].fit - now[n].exact));
      row.insert(row.end(), {now[n].exact, now[n].fit});
    }
    if (k % std::max(1, steps / 10) == 0) rows.add(row);
  }
  context.write(picture, chart);
  return largest;
}

std::vector<Constant> mode_1_constants(double c) {
  const ThreeTermConstants exact = exact_lambert_sphere_constants(c),
                           fit = fitted_lambert_sphere_constants(c);
  return {{"l", exact.l, fit.l}, {"m", exact.m, fit.m}};
}

std::vector<Constant> mode_0_constants(double c) {
  const auto exact = exact_lambert_sphere_constants(c).mode_0,
             fit = fitted_lambert_sphere_constants(c).mode_0;
  return {{"B", exact[1], fit[1]},
          {"C", exact[2], fit[2]},
          {"D", exact[3], fit[3]},
          {"F", exact[5], fit[5]}};
}

}  // namespace

Json reproduce_lambert_sphere_figure_4(ReproductionContext& context) {
  NumberRows rows(context, {{"albedo", "g"},
                            {"l", ".6f"},
                            {"l_fit", ".6f", "l fit"},
                            {"m", ".6f"},
                            {"m_fit", ".6f", "m fit"}});
  rows.header("the constants of eq. 27 from the moments of H1, and the fits of eqs. 31 and 32");
  const std::vector<double> largest =
      draw_constants(context, rows, "constants", "Constants of mode 1", mode_1_constants);
  context.find("simple approximations are very accurate",
               fmt::format("l is off by {:.1e}, m by {:.1e} at most", largest[0], largest[1]),
               largest[0] < 2e-3 && largest[1] < 0.02);
  return rows.rows();
}

Json reproduce_lambert_sphere_figure_6(ReproductionContext& context) {
  NumberRows rows(context, {{"albedo", "g"},
                            {"B", ".6f"},
                            {"B_fit", ".6f", "B fit"},
                            {"C", ".6f"},
                            {"C_fit", ".6f", "C fit"},
                            {"D", ".6f"},
                            {"D_fit", ".6f", "D fit"},
                            {"F", ".6f"},
                            {"F_fit", ".6f", "F fit"}});
  rows.header("the constants of eq. 36, exact, and the fits of eqs. 39 to 42");
  const std::vector<double> largest =
      draw_constants(context, rows, "constants", "Constants of mode 0", mode_0_constants);
  context.find("the fits follow the exact constants",
               fmt::format("largest distances {:.1e}, {:.1e}, {:.1e}, {:.1e} of B, C, D, F",
                           largest[0], largest[1], largest[2], largest[3]),
               *std::max_element(largest.begin(), largest.end()) < 5e-3);
  return rows.rows();
}

}  // namespace lamella
