#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/half_space/vmf_diffuse.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/map_sheet.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/vmf_figures.h"
#include "phase/stack/single_scattering.h"
#include "volume/solver/deterministic.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kModes = 3;
const std::vector<double> kRoughnesses{0.025, 0.05, 0.075, 0.1, 0.2, 0.3, 0.4,
                                       0.5,   0.6,  0.7,   0.8, 0.9, 1};

Stack white_flakes(double roughness) {
  return figure_stack("flakes", fmt::format("[[layer]]\nmedium = \"vmf_flake\"\nroughness = {}\n"
                                            "albedo = 1\nthickness = inf\n",
                                            roughness));
}

// Maps of the modes f_m, f = f_0 + 2 f_1 cos phi + 2 f_2 cos 2 phi, times the outgoing cosine. A
// row of a map has one incoming cosine, the highest first.
using Maps = std::vector<std::vector<double>>;

// Of order 1, from its exact values by the trapezoidal rule in phi.
Maps first_order(const Stack& stack, const std::vector<double>& mu,
                 const ReproductionContext& context) {
  constexpr int kAzimuths = 128;
  Maps maps(kModes, std::vector<double>(mu.size() * mu.size()));
  for (std::size_t i = 0; i < mu.size(); ++i)
    for (std::size_t o = 0; o < mu.size(); ++o) {
      context.go_on();
      double sums[kModes] = {};
      for (int k = 0; k < kAzimuths; ++k) {
        const double phi = 2 * kPi * k / kAzimuths;
        const double f = single_scattering(stack, direction_from_mu_phi(mu[i], 0),
                                           direction_from_mu_phi(mu[o], phi))
                             .layers.r;
        for (int m = 0; m < kModes; ++m) sums[m] += f * std::cos(m * phi) / kAzimuths;
      }
      for (int m = 0; m < kModes; ++m)
        maps[m][(mu.size() - 1 - i) * mu.size() + o] = sums[m] * mu[o];
    }
  return maps;
}

// Of orders 2 and 3 by the solver, which counts phi from the other side.
Maps solved_order(const Stack& stack, int order, const std::vector<double>& mu, double tolerance,
                  const ReproductionContext& context) {
  DeterministicOptions options{.tolerance = tolerance, .max_nodes = 64, .max_modes = 64};
  options.isa = isa_from_text("auto");
  options.stop = context.stop;
  const DeterministicSolution solution = solve_deterministic(stack, options);
  context.go_on();
  const DeterministicField field = solution.field(mu, mu);
  Maps maps(kModes, std::vector<double>(mu.size() * mu.size()));
  for (std::size_t i = 0; i < mu.size(); ++i)
    for (std::size_t o = 0; o < mu.size(); ++o)
      for (int m = 0; m < std::min(kModes, field.modes(0)); ++m)
        maps[m][(mu.size() - 1 - i) * mu.size() + o] =
            (m % 2 ? -1 : 1) * field.mode(0, order - 1, m, i, o) * mu[o];
  return maps;
}

Maps fitted(int order, double roughness, const std::vector<double>& mu) {
  Maps maps(kModes, std::vector<double>(mu.size() * mu.size()));
  for (int m = 0; m < kModes; ++m)
    for (std::size_t i = 0; i < mu.size(); ++i)
      for (std::size_t o = 0; o < mu.size(); ++o)
        maps[m][(mu.size() - 1 - i) * mu.size() + o] =
            vmf_diffuse_mode(order, m, roughness, mu[i], mu[o]) * mu[o];
  return maps;
}

double root_mean_square(const std::vector<double>& map) {
  double sum = 0;
  for (const double v : map) sum += v * v;
  return std::sqrt(sum / static_cast<double>(map.size()));
}

Json fourier_figure(ReproductionContext& context, int order) {
  const int side = context.by_quality(6, 16, 32);
  const std::vector<double> roughnesses =
      context.quality == Quality::draft ? std::vector<double>{0.1, 0.5, 1} : kRoughnesses;
  std::vector<double> mu;
  for (int k = 0; k < side; ++k) mu.push_back((k + 0.5) / side);
  MapSheet sheet{.title = fmt::format("Fourier components of f_{} cos \u03b8_o", order),
                 .subtitle =
                     "f = f\u2070 + 2 f\u00b9 cos \u03c6 + 2 f\u00b2 cos 2\u03c6, albedo 1; u_o to "
                     "the right, u_i upwards, both from 0 to 1; columns: roughness",
                 .columns = {},
                 .rows = {},
                 .side = side};
  for (int m = 0; m < kModes; ++m) {
    sheet.rows.push_back({.label = fmt::format("truth, {}", m),
                          .maps = {},
                          .is_signed = m > 0,
                          .same_scale = false});
    sheet.rows.push_back(
        {.label = fmt::format("fit, {}", m), .maps = {}, .is_signed = m > 0, .same_scale = true});
    sheet.rows.push_back({.label = "fit \u2212 truth", .maps = {}, .is_signed = true});
  }
  NumberRows rows(context, {{"roughness", "g"},
                            {"mode", "g"},
                            {"truth_rms", ".5f", "truth"},
                            {"fit_rms", ".5f", "fit"},
                            {"error_rms", ".5f", "error"},
                            {"error_most", ".5f", "largest"},
                            {"share", ".4f"},
                            {"factor", ".3f"}});
  rows.header(
      "root mean squares over the map; error: of fit less truth; share: of the error in that of "
      "mode 0;\nfactor: least-squares factor of the fit that comes nearest to the truth");
  double worst = 0, missing = 0;
  for (const double r : roughnesses) {
    if (is_set(context.stop)) return rows.rows();
    const Stack stack = white_flakes(r);
    const Maps truth =
        order == 1 ? first_order(stack, mu, context)
                   : solved_order(stack, order, mu, context.by_quality(1e-2, 1e-3, 1e-4), context);
    const Maps fit = fitted(order, r, mu);
    const double scale = root_mean_square(truth[0]);
    sheet.columns.push_back(fmt::format("{:g}", r));
    double all = 0;
    for (int m = 0; m < kModes; ++m) {
      std::vector<double> error(truth[m].size());
      double most = 0, product = 0, square = 0;
      for (std::size_t k = 0; k < error.size(); ++k) {
        error[k] = fit[m][k] - truth[m][k];
        most = std::max(most, std::abs(error[k]));
        product += fit[m][k] * truth[m][k];
        square += fit[m][k] * fit[m][k];
      }
      const double rms = root_mean_square(error);
      rows.add({r, static_cast<double>(m), root_mean_square(truth[m]), root_mean_square(fit[m]),
                rms, most, rms / scale, square > 0 ? product / square : std::nan("")});
      all = std::max(all, rms / scale);
      // What the paper leaves out of orders 2 and 3.
      if (order > 1 && m == 2) missing = std::max(missing, root_mean_square(truth[m]) / scale);
      sheet.rows[3 * m].maps.push_back(truth[m]);
      sheet.rows[3 * m + 1].maps.push_back(fit[m]);
      sheet.rows[3 * m + 2].maps.push_back(std::move(error));
    }
    worst = std::max(worst, all);
  }
  context.write("maps", [&](PictureFormat format) { return draw_map_sheet(sheet, format); });
  context.find("the error shows a close match over all roughnesses and pairs of cosines",
               fmt::format("the largest error of a component is {:.1f} % of mode 0's root mean "
                           "square",
                           100 * worst),
               worst < 0.1);
  if (order > 1)
    context.find("the component of cos 2 phi has negligible energy",
                 fmt::format("its root mean square is at most {:.2f} % of mode 0's", 100 * missing),
                 missing < 0.02);
  return rows.rows();
}

}  // namespace

Json reproduce_vmf_figure_4(ReproductionContext& context) { return fourier_figure(context, 1); }
Json reproduce_vmf_figure_11(ReproductionContext& context) { return fourier_figure(context, 2); }
Json reproduce_vmf_figure_12(ReproductionContext& context) { return fourier_figure(context, 3); }

}  // namespace lamella
