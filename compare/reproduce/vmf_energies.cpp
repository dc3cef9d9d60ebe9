#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/model/model.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/vmf_figures.h"
#include "volume/quadrature/quadrature.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Energies of orders 1, 2, 3 and 4+, averaged over a uniformly lit hemisphere, per channel.
using OrderEnergies = std::array<Rgb, kTallyOrders>;

OrderEnergies solved(const Stack& stack, const ReproductionContext& context) {
  const Quadrature rule = gauss_legendre(12);
  DeterministicOptions options{.tolerance = 1e-3, .max_nodes = 64, .max_modes = 16};
  options.isa = isa_from_text("auto");
  options.stop = context.stop;
  const std::vector<double> mu(rule.points.begin(), rule.points.end());
  const auto energies = solve_deterministic(stack, options).energies(mu);
  OrderEnergies result{};
  for (std::size_t k = 0; k < mu.size(); ++k)
    for (int order = 0; order < kTallyOrders; ++order)
      result[order] += 2 * mu[k] * rule.weights[static_cast<Eigen::Index>(k)] *
                       energies[k].reflected[static_cast<Order>(order)];
  return result;
}

// The same of the four lobes, by Gauss's rule in both cosines and equal steps in phi.
OrderEnergies of_lobes(const Model& model) {
  constexpr int kAzimuths = 32;
  const Quadrature rule = gauss_legendre(24);
  OrderEnergies result{};
  std::array<Rgb, kTallyOrders> lobes;
  for (int i = 0; i < rule.points.size(); ++i)
    for (int o = 0; o < rule.points.size(); ++o)
      for (int k = 0; k < kAzimuths; ++k) {
        const double phi = kPi * (k + 0.5) / kAzimuths;
        model.eval_lobes(direction_from_mu_phi(rule.points[i], 0),
                         direction_from_mu_phi(rule.points[o], phi), lobes);
        const double weight = 2 * rule.points[i] * rule.weights[i] * rule.points[o] *
                              rule.weights[o] * 2 * kPi / kAzimuths;
        for (int order = 0; order < kTallyOrders; ++order) result[order] += weight * lobes[order];
      }
  return result;
}

constexpr std::array<const char*, kTallyOrders> kNames{"f1", "f2", "f3", "fm"};

}  // namespace

Json reproduce_vmf_figure_3(ReproductionContext& context) {
  const std::vector<double> roughnesses =
      context.quality == Quality::draft
          ? std::vector<double>{0.1, 1}
          : std::vector<double>{0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1};
  const std::vector<std::array<double, 3>> albedos{{0.2, 0.4, 0.6}, {0.8, 0.95, 1}};
  NumberRows rows(context, {{"albedo", "g"},
                            {"roughness", "g"},
                            {"f1", ".4f"},
                            {"f1_lobe", ".4f", "f1 lobe"},
                            {"f2", ".4f"},
                            {"f2_lobe", ".4f", "f2 lobe"},
                            {"f3", ".4f"},
                            {"f3_lobe", ".4f", "f3 lobe"},
                            {"fm", ".4f"},
                            {"fm_lobe", ".4f", "fm lobe"},
                            {"all", ".4f"}});
  rows.header(
      "energies of orders 1, 2, 3 and 4+ under uniform light, by the solver and by the lobe");
  Chart chart{.title = "Energy of the orders over the roughness, albedo 1",
              .subtitle = "dots: solver; lines: lobes of the closed form",
              .x_label = "r",
              .y_label = "share of uniform light",
              .series = {}};
  Chart by_albedo = chart;
  by_albedo.title = "Energy of the orders over the albedo, r = 1";
  by_albedo.x_label = "albedo";
  for (Chart* c : {&chart, &by_albedo})
    for (const char* name : kNames) {
      c->series.push_back({.label = name, .x = {}, .y = {}});
      c->series.push_back({.label = "", .x = {}, .y = {}, .dots = true, .same_color = true});
    }
  int mostly_single = 0, cases = 0;
  double worst = 0, single_least = 1, multiple_of_white = 0, multiple_of_dark = 0, total = 0;
  for (const double r : roughnesses)
    for (const auto& albedo : albedos) {
      if (is_set(context.stop)) return rows.rows();
      const std::string color = fmt::format("{},{},{}", albedo[0], albedo[1], albedo[2]);
      const OrderEnergies truth = solved(
          figure_stack("flakes", fmt::format("[[layer]]\nmedium = \"vmf_flake\"\nroughness = "
                                             "{}\nalbedo = [{}]\nthickness = inf\n",
                                             r, color)),
          context);
      const OrderEnergies lobes = of_lobes(
          *figure_model(fmt::format("vmf_diffuse,roughness={},albedo={}", r, color)).model);
      for (int channel = 0; channel < 3; ++channel) {
        std::vector<NumberRows::Value> row{albedo[channel], r};
        double all = 0;
        for (int order = 0; order < kTallyOrders; ++order) {
          const double e = truth[order][channel], fit = lobes[order][channel];
          row.insert(row.end(), {e, fit});
          all += e;
          worst = std::max(worst, std::abs(e - fit));
          const auto add = [&](Chart& c, double x) {
            c.series[2 * order].x.push_back(x);
            c.series[2 * order].y.push_back(fit);
            c.series[2 * order + 1].x.push_back(x);
            c.series[2 * order + 1].y.push_back(e);
          };
          if (albedo[channel] == 1) add(chart, r);
          if (r == 1) add(by_albedo, albedo[channel]);
        }
        row.emplace_back(all);
        rows.add(row);
        const double single = truth[0][channel] / all;
        single_least = std::min(single_least, single);
        mostly_single += single > 0.5;
        ++cases;
        if (r == 1 && albedo[channel] == 1) multiple_of_white = truth[3][channel] / all;
        if (r == 1 && albedo[channel] == 0.2) multiple_of_dark = truth[3][channel] / all;
        if (albedo[channel] == 1) total = std::max(total, std::abs(all - 1));
      }
    }
  context.write("over_roughness", chart);
  context.write("over_albedo", by_albedo);
  context.find(
      "the majority of the energy is in single scattering",
      fmt::format("more than half in {} of {} cases; {:.1f} % at the highest albedo and roughness",
                  mostly_single, cases, 100 * single_least),
      2 * mostly_single > cases);
  context.find("at high albedo and roughness a significant amount is in f_m",
               fmt::format("{:.1f} % at r = 1 and albedo 1, {:.2f} % at albedo 0.2",
                           100 * multiple_of_white, 100 * multiple_of_dark),
               multiple_of_white > 0.05 && multiple_of_white > multiple_of_dark);
  context.find("a large number of orders is kept, so that no energy is lost",
               fmt::format("by the solver white flakes reflect 1 within {:.0e}; the lobes' "
                           "energies are off by up to {:.3f}",
                           total, worst),
               total < 2e-3);
  return rows.rows();
}

}  // namespace lamella
