#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/layered/micrograin.h"
#include "compare/drawing/chart.h"
#include "compare/judge/furnace.h"
#include "compare/reproduce/micrograin_figures.h"
#include "compare/request/interrupt.h"
#include "phase/math/sampling.h"
#include "volume/grains/grain_scene.h"
#include "volume/result/tally.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kRealisations = 64;

GrainGeometry grains(double tau0, double beta) {
  return {.placement = GrainPlacement::micrograins,
          .radius = 1,
          .thickness = beta,
          .tau0 = tau0,
          .beta = beta,
          .tile = 40};
}

/// Mean and standard error over realisations.
struct Samples {
  std::vector<double> values;

  [[nodiscard]] Estimate estimate() const {
    const double n = static_cast<double>(values.size());
    double mean = 0, sum = 0;
    for (const double v : values) mean += v / n;
    for (const double v : values) sum += (v - mean) * (v - mean);
    return {mean, std::sqrt(sum / (n - 1) / n)};
  }
};

double z_of(const Estimate& e, double expected) {
  return e.standard_error > 0 ? (e.value - expected) / e.standard_error : 0;
}

void row(const ReproductionContext& context, Json& rows,
         std::vector<std::pair<std::string, double>> keys, double analytic, const Estimate& e) {
  if (context.table) {
    for (const auto& key : keys) fmt::print(context.table, "{:>9.4g} ", key.second);
    fmt::print(context.table, "{:>11.6f} {:>11.6f} {:>9.1e} {:>7.2f}\n", analytic, e.value,
               e.standard_error, z_of(e, analytic));
  }
  Json entry;
  for (const auto& key : keys) entry[key.first] = key.second;
  entry["analytic"] = analytic;
  entry["simulated"] = e.value;
  entry["standard_error"] = e.standard_error;
  entry["z"] = z_of(e, analytic);
  rows.push_back(std::move(entry));
}

void header(const ReproductionContext& context, const std::vector<std::string>& keys) {
  if (!context.table) return;
  for (const std::string& key : keys) fmt::print(context.table, "{:>9} ", key);
  fmt::print(context.table, "{:>11} {:>11} {:>9} {:>7}\n", "analytic", "simulated", "+-", "z");
}

// Realisations are independent, the rows of one are not: Bonferroni's bound holds all the same.
void closing(ReproductionContext& context, const Json& rows) {
  double sum = 0, largest = 0;
  for (const Json& r : rows) {
    const double z = r["z"].get<double>();
    sum += z * z / static_cast<double>(rows.size());
    largest = std::max(largest, std::abs(z));
  }
  const double bound = furnace_quantile(1e-3 / static_cast<double>(rows.size()));
  context.find(
      "the analytic curves agree with numerical simulations",
      fmt::format("z of {} values: root mean square {:.2f}, largest {:.2f}; {:.2f} would be "
                  "exceeded once in a thousand",
                  rows.size(), std::sqrt(sum), largest, bound),
      largest < bound);
}

/// The share of vertical or slanted rays that meet grains, or the normals that they meet.
template <class F>
void for_realisations(const ReproductionContext& context, const GrainGeometry& g, const F& f) {
  for (int k = 0; k < kRealisations && !is_set(context.stop); ++k) {
    const auto centres = place_grains(g, context.seed, k);
    const GrainScene scene(g, centres);
    RandomStream stream(context.seed, k, StreamPurpose::measure);
    f(centres, scene, stream);
  }
}

}  // namespace

Json reproduce_micrograin_figure_4(ReproductionContext& context) {
  constexpr int kBins = 16;
  Json rows = Json::array();
  Chart density{
      .title = "Distance to the closest grain",
      .subtitle =
          "lines: 2\u03c0\u03c1r exp(\u2212\u03c1\u03c0r\u00b2); dots: simulated, with errors",
      .x_label = "r / r_s",
      .y_label = "density p(r) r_s",
      .series = {}};
  header(context, {"tau0", "r / r_s"});
  for (const double tau0 : {0.1, 0.4, 0.7, 0.9}) {
    const GrainGeometry g = grains(tau0, 1);
    const double rho = g.number_density();
    const double reach = 1.6 / std::sqrt(rho * kPi), width = reach / kBins;
    std::vector<Samples> bins(kBins);
    Samples within;
    const std::uint64_t points = std::max<std::uint64_t>(16, context.walks / (4 * kRealisations));
    for_realisations(context, g, [&](const auto& centres, const GrainScene&, RandomStream& stream) {
      std::vector<double> counts(kBins);
      double inside = 0;
      for (std::uint64_t p = 0; p < points; ++p) {
        const double x = g.tile * stream.uniform(), y = g.tile * stream.uniform();
        double nearest = 1e300;
        for (const Direction& c : centres) {
          double dx = std::abs(c.x - x), dy = std::abs(c.y - y);
          dx = std::min(dx, g.tile - dx);
          dy = std::min(dy, g.tile - dy);
          nearest = std::min(nearest, dx * dx + dy * dy);
        }
        const double r = std::sqrt(nearest);
        if (r < reach) ++counts[static_cast<int>(r / width)];
        inside += r < g.radius;
      }
      const double n = static_cast<double>(points);
      for (int b = 0; b < kBins; ++b) bins[b].values.push_back(counts[b] / n / width);
      within.values.push_back(inside / n);
    });
    ChartSeries line{.label = fmt::format("\u03c4\u2080 = {:g}", tau0), .x = {}, .y = {}};
    ChartSeries dots{.label = "", .x = {}, .y = {}, .error = {}, .dots = true, .same_color = true};
    const auto pdf = [&](double r) { return 2 * kPi * rho * r * std::exp(-rho * kPi * r * r); };
    for (int k = 0; k <= 100; ++k) {
      line.x.push_back(reach * k / 100);
      line.y.push_back(pdf(line.x.back()));
    }
    for (int b = 0; b < kBins; ++b) {
      const Estimate e = bins[b].estimate();
      // The mean of the density over the bin.
      const double a = b * width, z = (b + 1) * width;
      const double mean = (std::exp(-rho * kPi * a * a) - std::exp(-rho * kPi * z * z)) / width;
      dots.x.push_back((a + z) / 2);
      dots.y.push_back(e.value);
      dots.error.push_back(e.standard_error);
      row(context, rows, {{"tau0", tau0}, {"r", (a + z) / 2}}, mean, e);
    }
    row(context, rows, {{"tau0", tau0}, {"r", 1}}, tau0, within.estimate());
    density.series.push_back(std::move(line));
    density.series.push_back(std::move(dots));
  }
  if (context.table)
    fmt::print(context.table,
               "(the last row of each tau0: the share of points nearer than r_s, the filling "
               "factor)\n");
  closing(context, rows);
  context.write("distances", density);
  return rows;
}

Json reproduce_micrograin_figure_5(ReproductionContext& context) {
  constexpr int kBins = 15;
  Json rows = Json::array();
  Chart chart{.title = "Distribution of the grains' normals",
              .subtitle = "lines: eq. 16; dots: normals met by vertical rays, with errors",
              .x_label = "\u03b8_m [degrees]",
              .y_label = "D cos \u03b8_m [sr\u207b\u00b9]",
              .series = {}};
  header(context, {"tau0", "beta", "theta_m"});
  for (const double beta : {0.3, 0.8})
    for (const double tau0 : {0.2, 0.6, 0.95}) {
      const GrainGeometry g = grains(tau0, beta);
      const std::uint64_t rays = std::max<std::uint64_t>(16, context.walks / (6 * kRealisations));
      std::vector<Samples> bins(kBins);
      const auto edge = [&](int b) { return std::cos(kPi / 2 * b / kBins); };
      for_realisations(context, g, [&](const auto&, const GrainScene& scene, RandomStream& stream) {
        std::vector<double> counts(kBins);
        double all = 0;
        for (std::uint64_t k = 0; k < rays; ++k) {
          const double x = g.tile * stream.uniform(), y = g.tile * stream.uniform();
          const GrainHit hit = scene.trace({x, y, g.top()}, {0, 0, -1});
          if (hit.end != RayEnd::grain) continue;
          ++all;
          const double theta = std::acos(std::min(1.0, hit.normal.z));
          ++counts[std::min(kBins - 1, static_cast<int>(theta / (kPi / 2) * kBins))];
        }
        for (int b = 0; b < kBins; ++b) bins[b].values.push_back(all > 0 ? counts[b] / all : 0);
      });
      ChartSeries line{
          .label = fmt::format("\u03b2 = {:g}, \u03c4\u2080 = {:g}", beta, tau0), .x = {}, .y = {}};
      ChartSeries dots{
          .label = "", .x = {}, .y = {}, .error = {}, .dots = true, .same_color = true};
      for (int k = 0; k <= 89; ++k) {
        const double mu = std::cos(k * kPi / 180);
        line.x.push_back(k);
        line.y.push_back(micrograin_ndf(mu, tau0, beta) * mu);
      }
      for (int b = 0; b < kBins; ++b) {
        const Estimate e = bins[b].estimate();
        const double share = micrograin_ndf_cdf(std::max(0.0, edge(b + 1)), tau0, beta) -
                             micrograin_ndf_cdf(edge(b), tau0, beta);
        const double theta = 90.0 * (b + 0.5) / kBins;
        row(context, rows, {{"tau0", tau0}, {"beta", beta}, {"theta_m", theta}}, share, e);
        const double solid_angle = 2 * kPi * (edge(b) - edge(b + 1));
        dots.x.push_back(theta);
        dots.y.push_back(e.value / solid_angle);
        dots.error.push_back(e.standard_error / solid_angle);
      }
      chart.series.push_back(std::move(line));
      chart.series.push_back(std::move(dots));
    }
  closing(context, rows);
  context.write("normals", chart);
  return rows;
}

Json reproduce_micrograin_figure_9(ReproductionContext& context) {
  Json rows = Json::array();
  Chart chart{.title = "Visible filling factor",
              .subtitle = "lines: eq. 22; dots: share of rays that meet grains, with errors",
              .x_label = "\u03b8 [degrees]",
              .y_label = "\u03c4\u207a",
              .series = {}};
  header(context, {"tau0", "beta", "theta"});
  const std::vector<double> angles{0, 15, 30, 45, 60, 70, 80, 85};
  for (const double tau0 : {0.1, 0.4, 0.8})
    for (const double beta : {0.1, 0.4, 1.0}) {
      const GrainGeometry g = grains(tau0, beta);
      const std::uint64_t rays =
          std::max<std::uint64_t>(8, context.walks / (9 * angles.size() * kRealisations));
      std::vector<Samples> shares(angles.size());
      for_realisations(context, g, [&](const auto&, const GrainScene& scene, RandomStream& stream) {
        const double turn = 360 * stream.uniform();
        for (std::size_t a = 0; a < angles.size(); ++a) {
          const Direction d = -direction_from_degrees(angles[a], turn);
          double met = 0;
          for (std::uint64_t k = 0; k < rays; ++k) {
            const double x = g.tile * stream.uniform(), y = g.tile * stream.uniform();
            met += scene.trace({x, y, g.top()}, d).end == RayEnd::grain;
          }
          shares[a].values.push_back(met / static_cast<double>(rays));
        }
      });
      ChartSeries line{
          .label = fmt::format("\u03c4\u2080 = {:g}, \u03b2 = {:g}", tau0, beta), .x = {}, .y = {}};
      ChartSeries dots{
          .label = "", .x = {}, .y = {}, .error = {}, .dots = true, .same_color = true};
      for (int k = 0; k <= 89; ++k) {
        line.x.push_back(k);
        line.y.push_back(micrograin_tau_plus(std::cos(k * kPi / 180), tau0, beta));
      }
      for (std::size_t a = 0; a < angles.size(); ++a) {
        const Estimate e = shares[a].estimate();
        const double mu = std::cos(angles[a] * kPi / 180);
        row(context, rows, {{"tau0", tau0}, {"beta", beta}, {"theta", angles[a]}},
            micrograin_tau_plus(mu, tau0, beta), e);
        dots.x.push_back(angles[a]);
        dots.y.push_back(e.value);
        dots.error.push_back(e.standard_error);
      }
      chart.series.push_back(std::move(line));
      chart.series.push_back(std::move(dots));
    }
  closing(context, rows);
  context.write("filling_factor", chart);
  return rows;
}

}  // namespace lamella
