#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Middles of equal steps in mu^2.
std::vector<double> cosines_of(int count) {
  std::vector<double> mu;
  for (int k = 0; k < count; ++k) mu.push_back(std::sqrt((k + 0.5) / count));
  return mu;
}

}  // namespace

Json reproduce_lambert_sphere_figure_7(ReproductionContext& context) {
  constexpr double kAlbedo = 0.9;
  const Stack stack = figure_stack(
      "spheres",
      fmt::format("[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = {}\nthickness = inf\n",
                  kAlbedo));
  DeterministicOptions options{.tolerance = context.by_quality(1e-3, 1e-5, 1e-7), .max_nodes = 64};
  options.isa = isa_from_text("auto");
  options.stop = context.stop;
  const DeterministicSolution solution = solve_deterministic(stack, options);
  const BoundModel single = figure_model("single_scattering", &stack);
  struct Form {
    const char *label, *model;
  };
  const std::vector<Form> forms{{"analytic", "lambert_sphere"},
                                {"fast (eq. 48)", "lambert_sphere_fast"},
                                {"Hapke 1981", "hapke_lambert_sphere"}};
  std::vector<BoundModel> models;
  for (const Form& f : forms)
    models.push_back(figure_model(fmt::format("{},albedo={}", f.model, kAlbedo)));

  for (const double theta_i : {20.0, 50.0, 80.0}) {
    const Direction wi = direction_from_degrees(theta_i, 0);
    std::vector<double> angles, mu_o;
    for (int a = -86; a <= 86; a += 4) {
      angles.push_back(a);
      mu_o.push_back(std::cos(a * kPi / 180));
    }
    const double mu_i[] = {wi.z};
    const DeterministicField field = solution.field(mu_i, mu_o);
    Chart chart{
        .title = fmt::format("Lambert spheres, c = {:g}, \u03b8_i = {:g}\u00b0", kAlbedo, theta_i),
        .subtitle = "in the plane of incidence; \u03b8_o > 0 on the side of the light",
        .x_label = "\u03b8_o [degrees]",
        .y_label = "f cos \u03b8_o [sr\u207b\u00b9]",
        .series = {{.label = "solver", .x = angles, .y = {}, .error = {}, .dots = true}}};
    for (const Form& f : forms) chart.series.push_back({.label = f.label, .x = angles, .y = {}});
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const double phi = angles[k] < 0 ? kPi : 0;
      const Direction wo = direction_from_degrees(std::abs(angles[k]), angles[k] < 0 ? 180 : 0);
      chart.series[0].y.push_back(wo.z * (field.multiple(0, k, kPi - phi).order[Order::all].g +
                                          single.model->eval(wi, wo).g));
      for (std::size_t m = 0; m < models.size(); ++m)
        chart.series[m + 1].y.push_back(wo.z * models[m].model->eval(wi, wo).g);
    }
    context.write(fmt::format("theta_{:g}", theta_i), chart);
  }

  NumberRows rows(context, {{"model", "", "", 14},
                            {"relative_rmse", ".4f", "RMSE"},
                            {"grazing_rmse", ".4f", "grazing"},
                            {"grazing_mean", "+.4f", "mean"},
                            {"nanoseconds", ".0f", "ns"}});
  rows.header(
      "against the solver over all pairs of directions with equal projected solid angles: relative "
      "RMSE, the\nsame and the mean difference where both cosines are below 0.4; time of an "
      "evaluation");
  const std::vector<double> mu = cosines_of(context.by_quality(8, 20, 40));
  const DeterministicField field = solution.field(mu, mu);
  std::vector<double> rmse, grazing, mean, times;
  for (std::size_t m = 0; m < models.size(); ++m) {
    double square = 0, scale = 0, low_square = 0, low_scale = 0, low_sum = 0, low_truth = 0;
    for (std::size_t i = 0; i < mu.size(); ++i)
      for (std::size_t o = 0; o < mu.size(); ++o)
        for (int k = 0; k < 16; ++k) {
          const double phi = kPi * (k + 0.5) / 16;
          const Direction wi = direction_from_mu_phi(mu[i], 0);
          const Direction wo = direction_from_mu_phi(mu[o], phi);
          const double t =
              field.multiple(i, o, kPi - phi).order[Order::all].g + single.model->eval(wi, wo).g;
          const double d = models[m].model->eval(wi, wo).g - t;
          square += d * d;
          scale += t * t;
          if (mu[i] > 0.4 || mu[o] > 0.4) continue;
          low_square += d * d;
          low_scale += t * t;
          low_sum += d;
          low_truth += t;
        }
    rmse.push_back(std::sqrt(square / scale));
    grazing.push_back(std::sqrt(low_square / low_scale));
    mean.push_back(low_sum / low_truth);
    times.push_back(nanoseconds_per_eval(*models[m].model));
    rows.add({forms[m].label, rmse[m], grazing[m], mean[m], times[m]});
  }
  context.find(
      "Hapke's model underpredicts the reflectance at grazing angles",
      fmt::format("where both cosines are below 0.4 it is {:+.1f} % off on average", 100 * mean[2]),
      mean[2] < -0.01);
  context.find("the fast form is more accurate than Hapke's at a similar cost",
               fmt::format("relative RMSE {:.1f} % and {:.1f} %, {:.0f} and {:.0f} ns",
                           100 * rmse[1], 100 * rmse[2], times[1], times[2]),
               rmse[1] < rmse[2] && times[1] < 3 * times[2]);
  context.find("the analytic form is the most accurate",
               fmt::format("relative RMSE {:.2f} %", 100 * rmse[0]),
               rmse[0] < rmse[1] && rmse[0] < rmse[2]);
  return rows.rows();
}

}  // namespace lamella
