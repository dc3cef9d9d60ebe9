#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/rough_surface/eon.h"
#include "analytic/rough_surface/oren_nayar.h"
#include "compare/reproduce/eon_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Directions that stand for the hemisphere: middles of equal steps in mu^2 (so that each has the
// same projected solid angle) and in the azimuth.
std::vector<Direction> hemisphere(int cosines, int azimuths) {
  std::vector<Direction> all;
  for (int i = 0; i < cosines; ++i)
    for (int k = 0; k < azimuths; ++k)
      all.push_back(
          direction_from_mu_phi(std::sqrt((i + 0.5) / cosines), 2 * kPi * (k + 0.5) / azimuths));
  return all;
}

// A model against the full one over all pairs of directions.
struct Distance {
  double relative = 0;  // root mean square difference over root mean square
  double shape = 0;     // the same at the factor that makes it least
  double brighter = 0;  // share of the pairs where it is brighter
  double backlit = 0;   // mean difference where the azimuths are more than 90 degrees apart, over
                        // the mean of the other there
};

Distance distance(const Model& model, const Model& from, int cosines) {
  const std::vector<Direction> outgoing = hemisphere(cosines, 4 * cosines);
  double aa = 0, ab = 0, bb = 0, brighter = 0, pairs = 0, backlit = 0, backlit_from = 0;
  for (int i = 0; i < cosines; ++i) {
    const Direction wi = direction_from_mu_phi(std::sqrt((i + 0.5) / cosines), 0);
    for (const Direction wo : outgoing) {
      const double a = model.eval(wi, wo).g, b = from.eval(wi, wo).g;
      aa += a * a;
      ab += a * b;
      bb += b * b;
      brighter += a > b;
      ++pairs;
      if (wo.x >= 0) continue;
      backlit += a - b;
      backlit_from += b;
    }
  }
  return {std::sqrt((aa - 2 * ab + bb) / bb), std::sqrt(std::max(0.0, 1 - ab * ab / (aa * bb))),
          brighter / pairs, backlit / backlit_from};
}

// The directional albedo by cubature, whatever closed form the model has for it.
double integrated_albedo(const Model& model, double mu) {
  return model.Model::albedo_with_error(direction_from_mu_phi(mu, 0)).value.g;
}

// What figures 6 and 7 have in common.
struct AlbedoFigure {
  std::string model, parameter, symbol;
  std::vector<double> values;
  double (*directional)(double mu, double parameter);
  double (*average)(double parameter);
};

double closed_oren_nayar(double mu, double sigma) {
  return figure_model(fmt::format("oren_nayar,albedo=1,sigma={}", sigma))
      .model->albedo(direction_from_mu_phi(mu, 0))
      .g;
}

double closed_oren_nayar_average(double sigma) {
  const double s2 = sigma * sigma;
  return 1 - 0.5 * s2 / (s2 + 0.33) + kOrenNayarMean * 0.45 * s2 / (s2 + 0.09);
}

// Draws both panels, fills the rows, and gives the largest difference between closed form and
// quadrature.
double draw_albedos(ReproductionContext& context, const AlbedoFigure& figure, NumberRows& rows) {
  const int angles = context.by_quality(7, 19, 46);
  Chart directional{.title = fmt::format("Directional albedo of {}", figure.model),
                    .subtitle = "lines: closed form; dots: cubature of the values",
                    .x_label = "\u03b8 [degrees]",
                    .y_label = "albedo at \u03c1 = 1",
                    .series = {},
                    .from_zero = false};
  Chart average = directional;
  average.title = fmt::format("Average albedo of {}", figure.model);
  average.x_label = figure.symbol;
  ChartSeries closed_averages{.label = "closed form", .x = {}, .y = {}};
  ChartSeries averages{.label = "cubature", .x = {}, .y = {}, .dots = true, .same_color = true};
  double largest = 0;
  for (const double value : figure.values) {
    const BoundModel model =
        figure_model(fmt::format("{},albedo=1,{}={}", figure.model, figure.parameter, value));
    ChartSeries line{.label = fmt::format("{} = {:.3g}", figure.symbol, value), .x = {}, .y = {}};
    ChartSeries dots{.label = "", .x = {}, .y = {}, .dots = true, .same_color = true};
    for (int k = 0; k < angles; ++k) {
      const double theta = 89.9 * k / (angles - 1), mu = std::cos(theta * kPi / 180);
      const double closed = figure.directional(mu, value);
      const double integral = integrated_albedo(*model.model, mu);
      line.x.push_back(theta);
      line.y.push_back(closed);
      dots.x.push_back(theta);
      dots.y.push_back(integral);
      largest = std::max(largest, std::abs(closed - integral));
    }
    // Cosine-weighted mean over the hemisphere, by Gauss's rule in the angle, in which both albedos
    // are smooth up to the horizon.
    double mean = 0;
    const Quadrature& rule = cached_gauss_legendre(20);
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      const double theta = kPi / 2 * rule.points[k];
      mean += kPi / 2 * rule.weights[k] * std::sin(2 * theta) *
              integrated_albedo(*model.model, std::cos(theta));
    }
    const double closed_mean = figure.average(value);
    closed_averages.x.push_back(value);
    closed_averages.y.push_back(closed_mean);
    averages.x.push_back(value);
    averages.y.push_back(mean);
    largest = std::max(largest, std::abs(mean - closed_mean));
    rows.add({value, line.y.front(), dots.y.front(), line.y.back(), dots.y.back(), closed_mean,
              mean, mean - closed_mean});
    directional.series.push_back(std::move(line));
    directional.series.push_back(std::move(dots));
  }
  average.series = {closed_averages, averages};
  context.write("directional", directional);
  context.write("average", average);
  return largest;
}

std::vector<NumberColumn> albedo_columns(const std::string& parameter) {
  return {{parameter, ".4f"},
          {"normal", ".6f", "E(0)"},
          {"normal_integrated", ".6f", "E(0) quad."},
          {"grazing", ".6f", "E(89.9)"},
          {"grazing_integrated", ".6f", "E(89.9) q."},
          {"average", ".6f", "<E>"},
          {"average_integrated", ".6f", "<E> quad."},
          {"average_difference", ".1e", "difference"}};
}

}  // namespace

Json reproduce_eon_figure_3(ReproductionContext& context) {
  struct Curve {
    std::string name, request;
  };
  const std::string sigma = fmt::format(",albedo=0.8,sigma={}", kPi / 4);
  const std::vector<Curve> curves{{"fullON", "oren_nayar_full" + sigma},
                                  {"QON", "oren_nayar" + sigma},
                                  {"footnote QON", "oren_nayar_footnote" + sigma},
                                  {"Fujii QON", "fujii_qualitative" + sigma},
                                  {"FON", "fon,albedo=0.8,roughness=0.5"},
                                  {"EON", "eon,albedo=0.8,roughness=0.5"},
                                  {"Lambert", "lambert,albedo=0.8"}};
  std::vector<BoundModel> models;
  for (const Curve& c : curves) models.push_back(figure_model(c.request));

  std::vector<double> peaks;
  for (const double theta_i : {0.0, 30.0, 60.0, 80.0}) {
    const Direction wi = direction_from_degrees(theta_i, 0);
    Chart chart{.title = fmt::format("\u03b8_i = {:g}\u00b0", theta_i),
                .subtitle = "in the plane of incidence; \u03b8_o > 0 on the side of the light",
                .x_label = "\u03b8_o [degrees]",
                .y_label = "f cos \u03b8_i [sr\u207b\u00b9]",
                .series = {}};
    for (std::size_t m = 0; m < curves.size(); ++m) {
      ChartSeries s{.label = curves[m].name, .x = {}, .y = {}};
      for (int a = -88; a <= 88; a += 2) {
        s.x.push_back(a);
        s.y.push_back(
            wi.z *
            models[m].model->eval(wi, direction_from_degrees(std::abs(a), a < 0 ? 180 : 0)).g);
      }
      if (m == 0) peaks.push_back(*std::max_element(s.y.begin(), s.y.end()) * kPi / (0.8 * wi.z));
      chart.series.push_back(std::move(s));
    }
    context.write(fmt::format("theta_{:g}", theta_i), chart);
  }

  NumberRows rows(context, {{"model", "", "", 14},
                            {"relative_rmse", ".4f", "RMSE"},
                            {"shape", ".4f"},
                            {"brighter", ".4f"},
                            {"backlit", "+.4f"},
                            {"reflected", ".4f"},
                            {"largest_albedo", ".4f", "most"}});
  rows.header(
      "albedo 0.8, sigma = pi / 4 or r = 1/2; against the full model over all pairs of directions, "
      "each\nwith the same projected solid angle: relative RMSE; the same at the best common "
      "factor (shape);\nshare of the pairs where a model is brighter; mean difference where the "
      "azimuths differ by more\nthan 90 degrees; reflected under uniform light; largest "
      "directional albedo over sigma or r at albedo 1");
  const int cosines = context.by_quality(8, 24, 48);
  std::vector<Distance> distances;
  std::vector<double> reflected, largest;
  for (std::size_t m = 0; m < curves.size(); ++m) {
    distances.push_back(distance(*models[m].model, *models[0].model, cosines));
    double sum = 0, most = 0;
    for (int k = 0; k < cosines; ++k)
      sum += models[m].model->albedo(direction_from_mu_phi(std::sqrt((k + 0.5) / cosines), 0)).g /
             cosines;
    for (const double share : {0.0, 0.064, 0.127, 0.25, 0.5, 1.0}) {
      const std::string name = models[m].info->name;
      const std::string roughness = name == "lambert"  ? ""
                                    : m == 4 || m == 5 ? fmt::format(",roughness={}", share)
                                                       : fmt::format(",sigma={}", share * kPi / 2);
      const BoundModel white = figure_model(name + ",albedo=1" + roughness);
      for (const double mu : {1e-3, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0})
        most = std::max(most, white.model->albedo(direction_from_mu_phi(mu, 0)).g);
    }
    reflected.push_back(sum);
    largest.push_back(most);
    const Distance& d = distances.back();
    rows.add({curves[m].name, d.relative, d.shape, d.brighter, d.backlit, sum, most});
  }
  context.find("the peak of back scattering is most prominent in the grazing configuration",
               fmt::format("highest value of fullON over Lambert's: {:.2f}, {:.2f}, {:.2f}, {:.2f} "
                           "at theta_i 0, 30, 60, 80",
                           peaks[0], peaks[1], peaks[2], peaks[3]),
               peaks[3] > peaks[2] && peaks[2] > peaks[1] && peaks[1] > peaks[0]);
  context.find("QON is overly bright when backlit",
               fmt::format("beyond 90 degrees of azimuth QON is brighter than fullON by {:.1f} %",
                           100 * distances[1].backlit),
               distances[1].backlit > 0);
  context.find("fullON is reasonably approximated by Fujii QON, a change of QON's coefficients",
               fmt::format("relative RMSE {:.1f} %, QON's is {:.1f} %", 100 * distances[3].relative,
                           100 * distances[1].relative),
               distances[3].relative < distances[1].relative);
  context.find("FON closely matches the shape of fullON",
               fmt::format("at the best factor {:.1f} % apart, QON {:.1f} %",
                           100 * distances[4].shape, 100 * distances[1].shape),
               distances[4].shape < distances[1].shape);
  context.find("FON is brighter than fullON in most cases",
               fmt::format("in {:.0f} % of the pairs", 100 * distances[4].brighter),
               distances[4].brighter > 0.5);
  context.find("fullON and QON gain energy for some directions and roughnesses, FON does not",
               fmt::format("largest white albedos {:.3f}, {:.3f} and {:.6f}", largest[0],
                           largest[1], largest[4]),
               largest[0] > 1 && largest[1] > 1 && largest[4] < 1 + 1e-9);
  context.find("EON is brighter than the models that lose energy",
               fmt::format("of uniform light it reflects {:.3f}, FON {:.3f}, fullON {:.3f}, QON "
                           "{:.3f}, Lambert {:.3f}",
                           reflected[5], reflected[4], reflected[0], reflected[1], reflected[6]),
               reflected[5] > std::max({reflected[0], reflected[1], reflected[4]}));
  return rows.rows();
}

Json reproduce_eon_figure_6(ReproductionContext& context) {
  const AlbedoFigure figure{
      "oren_nayar",      "sigma",
      "\u03c3",          {0.05, 0.1, 0.198, 0.323, kPi / 8, kPi / 4, 3 * kPi / 8, kPi / 2},
      closed_oren_nayar, closed_oren_nayar_average};
  NumberRows rows(context, albedo_columns("sigma"));
  rows.header();
  const double largest = draw_albedos(context, figure, rows);
  context.find("eqs. 5 and 8 are the directional albedo, eq. 9 is the average",
               fmt::format("closed form and cubature differ by {:.1e} at most", largest),
               largest < 1e-6);
  // The limit at grazing is A + B / 2.
  const auto grazing = [](double sigma) {
    const double s2 = sigma * sigma;
    return 1 - 0.5 * s2 / (s2 + 0.33) + 0.5 * 0.45 * s2 / (s2 + 0.09);
  };
  double most = 0, at = 0, last = 0;
  for (int k = 1; k <= 1570; ++k) {
    const double sigma = k / 1000.0, e = grazing(sigma);
    if (e > most) most = e, at = sigma;
    if (e > 1) last = sigma;
  }
  context.find("the albedo exceeds 1 at grazing angles and high sigma",
               fmt::format("the grazing albedo exceeds 1 for sigma up to {:.3f}, most at {:.3f} "
                           "({:.4f}); at pi / 2 it is {:.3f}",
                           last, at, most, grazing(kPi / 2)),
               grazing(kPi / 2) > 1);
  context.find("the model loses significant energy at high sigma",
               fmt::format("{:.1f} % at pi / 2", 100 * (1 - closed_oren_nayar_average(kPi / 2))),
               closed_oren_nayar_average(kPi / 2) < 0.9);
  return rows.rows();
}

Json reproduce_eon_figure_7(ReproductionContext& context) {
  const AlbedoFigure figure{"fon",      "roughness",       "r", {0.2, 0.4, 0.6, 0.8, 1.0},
                            fon_albedo, fon_average_albedo};
  NumberRows rows(context, albedo_columns("roughness"));
  rows.header();
  const double largest = draw_albedos(context, figure, rows);
  Chart fit{.title = "Fit of FON's albedo, less the exact one",
            .subtitle = "eq. 14 less eqs. 12, 13",
            .x_label = "\u03b8 [degrees]",
            .y_label = "difference",
            .series = {}};
  double relative = 0, above = 0;
  for (const double r : figure.values) {
    ChartSeries s{.label = fmt::format("r = {:g}", r), .x = {}, .y = {}};
    for (int k = 0; k <= 900; ++k) {
      const double theta = k / 10.0, mu = std::max(0.0, std::cos(theta * kPi / 180));
      const double exact = fon_albedo(mu, r), fitted = fon_albedo_fit(mu, r);
      s.x.push_back(theta);
      s.y.push_back(fitted - exact);
      relative = std::max(relative, std::abs(fitted / exact - 1));
      above = std::max(above, fitted - 1);
    }
    fit.series.push_back(std::move(s));
  }
  context.write("fit", fit);
  context.find("eqs. 12 and 13 are the directional albedo, eq. 15 is the average",
               fmt::format("closed form and cubature differ by {:.1e} at most", largest),
               largest < 1e-6);
  context.find(
      "the fit of eq. 14 differs by less than 0.1 %",
      fmt::format("by {:.3f} % at most; it exceeds 1 by up to {:.1e}", 100 * relative, above),
      relative < 1e-3);
  context.find("at grazing the albedo is 1 whatever the roughness",
               fmt::format("1 - E = {:.1e} at r = 1", 1 - fon_albedo(0, 1)),
               std::abs(1 - fon_albedo(0, 1)) < 1e-12);
  const double lost = 1 - fon_average_albedo(1);
  context.find("approximately 20 % of the energy is lost at high roughness",
               fmt::format("{:.1f} % at r = 1", 100 * lost), std::abs(lost - 0.2) < 0.05);
  return rows.rows();
}

}  // namespace lamella
