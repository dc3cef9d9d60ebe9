#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/layered/micrograin.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/micrograin_figures.h"
#include "compare/reproduce/number_rows.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// G1 = 1 / (1 + Lambda) of a projected area (1 + Lambda) mu.
double masking(double mu, double area) { return std::min(1.0, mu / area); }

double ggx_lambda(double mu, double alpha) {
  const double tan2 = (1 - mu * mu) / (mu * mu);
  return (std::sqrt(1 + alpha * alpha * tan2) - 1) / 2;
}

// The share of the surface that grains show to both directions in the model of d'Eon et al., by
// eq. 26 for any pair: 1 - (1 - w_A)^(1 / G), G the masking of GGX for both.
double deon_weight(double mu_i, double mu_o, double w_a, double alpha) {
  const double inverse = 1 + ggx_lambda(mu_i, alpha) + ggx_lambda(mu_o, alpha);
  return 1 - std::pow(1 - w_a, inverse);
}

}  // namespace

Json reproduce_micrograin_figure_10(ReproductionContext& context) {
  constexpr double kTau0 = 0.98;  // the caption's
  NumberRows rows(context, {{"tau0", "g"},
                            {"beta", "g"},
                            {"five_terms", ".4f", "5 terms"},
                            {"twenty_one_terms", ".1e", "21 terms"},
                            {"ggx", ".4f", "GGX"},
                            {"ggx_least", "+.4f", "least"},
                            {"ggx_most", "+.4f", "most"}});
  rows.header(
      "G1 of the grains' normals: largest distance of n = 4, n = 20 and GGX from all terms; least "
      "and most of\nGGX less all terms");
  double five = 0, twenty = 0, ggx_high = 0, ggx_low = 0, above = -1;
  for (const double tau0 : {0.3, kTau0})
    for (const double beta : {0.3, 0.9}) {
      const double alpha = micrograin_equivalent_roughness(tau0, beta);
      Chart chart{.title = fmt::format("G\u2081, \u03c4\u2080 = {:g}, \u03b2 = {:g}", tau0, beta),
                  .subtitle = "series of eq. 25; GGX of the equivalent roughness",
                  .x_label = "\u03b8 [degrees]",
                  .y_label = "G\u2081",
                  .series = {{.label = "all terms", .x = {}, .y = {}},
                             {.label = "n = 4", .x = {}, .y = {}},
                             {.label = "n = 20", .x = {}, .y = {}},
                             {.label = "GGX", .x = {}, .y = {}}}};
      double distance[3] = {0, 0, 0}, least = 1, most = -1;
      for (int k = 0; k <= 178; ++k) {
        const double theta = k / 2.0, mu = std::cos(theta * kPi / 180);
        const auto series = [&](MicrograinShadowing shadowing, int terms) {
          return masking(mu, micrograin_projected_area(mu, tau0, beta, shadowing, terms));
        };
        const double all = series(MicrograinShadowing::smith, 4);
        const double values[] = {all, series(MicrograinShadowing::series, 4),
                                 series(MicrograinShadowing::series, 20),
                                 1 / (1 + ggx_lambda(mu, alpha))};
        for (int s = 0; s < 4; ++s) {
          chart.series[s].x.push_back(theta);
          chart.series[s].y.push_back(values[s]);
          if (s > 0) distance[s - 1] = std::max(distance[s - 1], std::abs(values[s] - all));
        }
        least = std::min(least, values[3] - all);
        most = std::max(most, values[3] - all);
      }
      rows.add({tau0, beta, distance[0], distance[1], distance[2], least, most});
      context.write(fmt::format("tau_{:g}_beta_{:g}", tau0, beta), chart);
      five = std::max(five, distance[0]);
      twenty = std::max(twenty, distance[1]);
      (tau0 == kTau0 ? ggx_high : ggx_low) =
          std::max(tau0 == kTau0 ? ggx_high : ggx_low, distance[2]);
      if (tau0 == kTau0) above = std::max(above, most);
    }
  context.find("n = 20 is a reference", fmt::format("off by {:.1e} at most", twenty),
               twenty < 1e-3);
  context.find("the five first terms give a very close approximation",
               fmt::format("G1 is off by up to {:.4f}", five), five < 0.03);
  context.find("GGX's G1 is a conservative approximation (not above), often sufficient at low tau0",
               fmt::format("off by up to {:.3f} at tau0 = 0.98 and {:.3f} at 0.3; above the exact "
                           "one by up to {:.1e} at 0.98",
                           ggx_high, ggx_low, above),
               above < 1e-6 && ggx_low < ggx_high);
  return rows.rows();
}

Json reproduce_micrograin_figure_11(ReproductionContext& context) {
  constexpr double kBeta = 0.5;  // the caption's
  NumberRows rows(context, {{"theta_i", "g"},
                            {"theta_o", "g"},
                            {"tau0", "g"},
                            {"weight", ".5f"},
                            {"deon", ".5f", "d'Eon"},
                            {"difference", "+.5f"}});
  rows.header(
      "beta = 0.5: weight of the grains by eq. 24, and by eq. 26 with the equivalent roughness; that "
      "of Merillou et al. 2000 is left out, as its source is not at hand");
  double at_normal = 0, largest = 0;
  for (const double theta_o : {0.0, 75.0}) {
    Chart chart{.title = fmt::format("Weight of the grains, \u03b8_o = {:g}\u00b0", theta_o),
                .subtitle = "lines: eq. 24; dots: d'Eon et al. by eq. 26",
                .x_label = "\u03b8_i [degrees]",
                .y_label = "w\u207a",
                .series = {}};
    for (const double tau0 : {0.1, 0.5, 0.9}) {
      const double alpha = micrograin_equivalent_roughness(tau0, kBeta);
      ChartSeries ours{.label = fmt::format("\u03c4\u2080 = {:g}", tau0), .x = {}, .y = {}};
      ChartSeries deon{.label = "", .x = {}, .y = {}, .dots = true, .same_color = true};
      for (int k = 0; k <= 88; k += 4) {
        const double mu_i = std::cos(k * kPi / 180), mu_o = std::cos(theta_o * kPi / 180);
        const double a = micrograin_weight(mu_i, mu_o, tau0, kBeta);
        const double b = deon_weight(mu_i, mu_o, tau0, alpha);
        ours.x.push_back(k);
        ours.y.push_back(a);
        deon.x.push_back(k);
        deon.y.push_back(b);
        if (k == 0 && theta_o == 0) at_normal = std::max(at_normal, std::abs(a - b));
        largest = std::max(largest, std::abs(a - b));
        if (k % 20 == 0) rows.add({static_cast<double>(k), theta_o, tau0, a, b, b - a});
      }
      chart.series.push_back(std::move(ours));
      chart.series.push_back(std::move(deon));
    }
    context.write(fmt::format("theta_o_{:g}", theta_o), chart);
  }
  // With beta in the place of the equivalent roughness eq. 26 is an identity.
  double identity = 0;
  for (const double tau0 : {0.1, 0.5, 0.9})
    for (const double mu : {0.05, 0.3, 0.7, 1.0})
      identity = std::max(identity, std::abs(deon_weight(1, mu, tau0, kBeta) -
                                             micrograin_tau_plus(mu, tau0, kBeta)));
  context.find("the models are equal at theta_i = theta_o = 0",
               fmt::format("they differ by {:.1e} there", at_normal), at_normal < 1e-12);
  context.find("elsewhere the two weights have a similar profile",
               fmt::format("they differ by up to {:.3f}; with beta in the place of the equivalent "
                           "roughness eq. 26 holds within {:.0e}",
                           largest, identity),
               largest < 0.1);
  return rows.rows();
}

}  // namespace lamella
