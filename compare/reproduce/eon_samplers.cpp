#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/model/clipped_cosine.h"
#include "analytic/rough_surface/eon.h"
#include "compare/judge/sampler_statistics.h"
#include "compare/reproduce/eon_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// A model with another sampler: a lobe without the clip.
class WithLobe final : public Model {
 public:
  WithLobe(const Model& model, const ClippedCosine& lobe) : Model(2), model_(model), lobe_(lobe) {}

  using Model::eval;
  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override { return model_.eval(wi, wo); }
  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    return model_.eval_lobe(lobe, wi, wo);
  }
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    return frame_towards(wo).to_world(lobe_.sample(HemisphereSampler::ltc, u1, u2, u3));
  }
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    return lobe_.pdf(HemisphereSampler::ltc, frame_towards(wo).to_local(wi));
  }

 private:
  const Model& model_;
  ClippedCosine lobe_;
};

// Second moment of the weight f mu_i / pdf of the lobe without the clip: the integral of (f mu_i)^2
// / pdf by the midpoint rule in mu^(1/2), which is fine at grazing, and the azimuth.
double second_moment(const Model& model, Direction wo, const ClippedCosine& lobe) {
  constexpr int kCosines = 48, kAzimuths = 48;
  double sum = 0;
  for (int i = 0; i < kCosines; ++i) {
    const double x = (i + 0.5) / kCosines, mu = x * x;
    for (int k = 0; k < kAzimuths; ++k) {
      const Direction wi = direction_from_mu_phi(mu, kPi * (k + 0.5) / kAzimuths);
      const double value = model.eval(wi, wo).g * mu;
      sum += value * value / lobe.pdf(HemisphereSampler::ltc, wi) * 2 * x;
    }
  }
  return sum * 2 * kPi / (kCosines * kAzimuths);
}

// The share of the reflected light that comes from directions which the clipped lobe never draws,
// by the same rule.
double never_drawn(const Model& model, Direction wo, const ClippedCosine& lobe) {
  constexpr int kCosines = 96, kAzimuths = 96;
  double missed = 0, all = 0;
  for (int i = 0; i < kCosines; ++i) {
    const double x = (i + 0.5) / kCosines, mu = x * x;
    for (int k = 0; k < kAzimuths; ++k) {
      const Direction wi = direction_from_mu_phi(mu, kPi * (k + 0.5) / kAzimuths);
      const double value = model.eval(wi, wo).g * mu * x;
      all += value;
      if (lobe.pdf(HemisphereSampler::cltc, wi) == 0) missed += value;
    }
  }
  return missed / all;
}

// The lobe with d = 0 of least second moment: a search along a, b and c whose steps are halved.
ClippedCosine best_without_shear(const Model& model, Direction wo, ClippedCosine start) {
  start.d = 0;
  const auto moment = [&](const ClippedCosine& lobe) { return second_moment(model, wo, lobe); };
  double least = moment(start);
  for (double step = 0.4; step > 2e-3; step /= 2)
    for (bool better = true; better;) {
      better = false;
      for (const int which : {0, 1, 2})
        for (const double sign : {1.0, -1.0}) {
          ClippedCosine lobe = start;
          if (which == 0) lobe.a *= std::exp(sign * step);
          if (which == 1) lobe.b += sign * step;
          if (which == 2) lobe.c *= std::exp(sign * step);
          const double now = moment(lobe);
          if (now >= least * (1 - 1e-6)) continue;
          least = now;
          start = lobe;
          better = true;
        }
    }
  return start;
}

struct Sampler {
  std::string name, key;
};
const std::array<Sampler, 6> kSamplers{{{"cosine", "cosine"},
                                        {"uniform", "uniform"},
                                        {"LTC, d = 0", ""},
                                        {"LTC", "ltc"},
                                        {"CLTC", "cltc"},
                                        {"CLTC + uniform", "mis"}}};

}  // namespace

Json reproduce_eon_figure_11(ReproductionContext& context) {
  const std::vector<double> angles =
      context.quality == Quality::draft
          ? std::vector<double>{0, 60, 89}
          : std::vector<double>{0, 10, 20, 30, 40, 50, 60, 65, 70, 75, 80, 82, 84, 86, 88, 89};
  const std::uint64_t samples =
      std::max<std::uint64_t>(100, context.walks / (angles.size() * kSamplers.size()));
  Chart variances{.title = "Variance of the weight f cos / pdf, EON, r = 1",
                  .subtitle = fmt::format("{} samples per angle and sampler", samples),
                  .x_label = "\u03b8_o [degrees]",
                  .y_label = "variance",
                  .series = {},
                  .log_y = true};
  Chart largest = variances, means = variances;
  largest.title = "Largest weight, EON, r = 1";
  largest.y_label = "largest weight";
  means.title = "Mean weight, EON, r = 1";
  means.y_label = "mean weight";
  means.log_y = false;
  means.from_zero = false;
  NumberRows rows(context, {{"sampler", "", "", 15},
                            {"theta", "g"},
                            {"variance", ".3e"},
                            {"largest", ".4f"},
                            {"mean", ".5f"},
                            {"mean_error", ".1e", "+-"},
                            {"lost", ".5f"}});
  rows.header(
      fmt::format("r = 1, albedo 1; {} samples each; lost: share of samples below the "
                  "surface or of weight 0",
                  samples));
  std::vector<std::vector<SamplerStatistics>> all;
  for (std::size_t s = 0; s < kSamplers.size(); ++s) {
    const Sampler& sampler = kSamplers[s];
    const BoundModel model = figure_model("eon,albedo=1,roughness=1" +
                                          (sampler.key.empty() ? "" : ",sampler=" + sampler.key));
    ChartSeries v{.label = sampler.name, .x = angles, .y = {}}, l = v, m = v;
    auto& statistics = all.emplace_back();
    for (const double theta : angles) {
      if (is_set(context.stop)) return rows.rows();
      const Direction wo = direction_from_degrees(theta, 0);
      SamplerStatistics now;
      if (sampler.key.empty())
        now = sampler_statistics(
            WithLobe(*model.model,
                     best_without_shear(*model.model, wo, eon_sampling_lobe(wo.z, 1))),
            wo, samples, context.seed);
      else
        now = sampler_statistics(*model.model, wo, samples, context.seed);
      statistics.push_back(now);
      v.y.push_back(now.variance);
      l.y.push_back(now.max_weight);
      m.y.push_back(now.mean);
      rows.add(
          {sampler.name, theta, now.variance, now.max_weight, now.mean, now.mean_error, now.lost});
    }
    variances.series.push_back(std::move(v));
    largest.series.push_back(std::move(l));
    means.series.push_back(std::move(m));
  }
  context.write("variance", variances);
  context.write("largest_weight", largest);
  context.write("mean_weight", means);

  const std::size_t last = angles.size() - 1;
  enum { cosine, uniform, shearless, ltc, cltc, mis };
  const auto variance = [&](int s, std::size_t k) { return all[s][k].variance; };
  context.find("with cosine sampling the variance grows by a factor of over 100 towards grazing",
               fmt::format("from {:.2e} at the normal to {:.2e} at 89 degrees, by {:.0f}",
                           variance(cosine, 0), variance(cosine, last),
                           variance(cosine, last) / variance(cosine, 0)),
               variance(cosine, last) > 100 * variance(cosine, 0));
  context.find("uniform sampling has less variance at grazing and more elsewhere",
               fmt::format("{:.2f} of the cosine's at 89 degrees, {:.1f} at the normal",
                           variance(uniform, last) / variance(cosine, last),
                           variance(uniform, 0) / variance(cosine, 0)),
               variance(uniform, last) < variance(cosine, last) &&
                   variance(uniform, 0) > variance(cosine, 0));
  context.find("with d = 0 the variance is still high at grazing, the general lobe lowers it much",
               fmt::format("at 89 degrees {:.2e} with d = 0, {:.2e} with d free, {:.2e} of the "
                           "cosine's",
                           variance(shearless, last), variance(ltc, last), variance(cosine, last)),
               variance(ltc, last) < 0.5 * variance(shearless, last) &&
                   variance(shearless, last) < variance(cosine, last));
  double wasted = 0;
  for (const SamplerStatistics& s : all[ltc]) wasted = std::max(wasted, s.lost);
  context.find("the lobe without the clip wastes samples below the hemisphere",
               fmt::format("up to {:.2f} % of them", 100 * wasted), wasted > 0);
  double outlier = 0, of_uniform = 0, of_mis = 0, bias = 0, mis_bias = 0;
  const BoundModel exact = figure_model("eon,albedo=1,roughness=1");
  for (std::size_t k = 0; k < angles.size(); ++k) {
    outlier = std::max(outlier, all[cltc][k].max_weight);
    of_uniform = std::max(of_uniform, all[uniform][k].max_weight);
    of_mis = std::max(of_mis, all[mis][k].max_weight);
    const Direction wo = direction_from_degrees(angles[k], 0);
    bias = std::max(bias, never_drawn(*exact.model, wo, eon_sampling_lobe(wo.z, 1)));
    mis_bias = std::max(mis_bias, std::abs(all[mis][k].mean - 1) / all[mis][k].mean_error);
  }
  context.find("CLTC alone has high outliers of the weight, the mixture has not",
               fmt::format("largest weights {:.1f}, uniform {:.1f}, mixture {:.1f}", outlier,
                           of_uniform, of_mis),
               outlier > of_uniform && of_mis < of_uniform);
  context.find(
      "CLTC alone has a slight bias, the mixture none",
      fmt::format("up to {:.2f} % of the light comes from directions that CLTC never draws "
                  "(quadrature); the mean of the mixture is off by at most {:.1f} standard "
                  "errors",
                  100 * bias, mis_bias),
      bias > 0 && bias < 0.05 && mis_bias < 4);
  context.find(
      "the mixture has a variance like the cosine's at the normal and 100 times less at "
      "grazing",
      fmt::format("{:.2f} of the cosine's at the normal, 1 / {:.0f} at 89 degrees",
                  variance(mis, 0) / variance(cosine, 0),
                  variance(cosine, last) / variance(mis, last)),
      variance(cosine, last) > 50 * variance(mis, last) &&
          variance(mis, 0) < 3 * variance(cosine, 0));
  return rows.rows();
}

Json reproduce_eon_figure_13(ReproductionContext& context) {
  const std::vector<double> roughnesses{0, 0.1, 0.25, 0.5, 0.75, 1};
  const std::vector<double> angles = context.quality == Quality::draft
                                         ? std::vector<double>{0, 89}
                                         : std::vector<double>{0, 20, 40, 60, 70, 80, 85, 89};
  const std::uint64_t samples =
      std::max<std::uint64_t>(100, context.walks / (2 * angles.size() * roughnesses.size()));
  NumberRows rows(context, {{"roughness", "g"},
                            {"theta", "g"},
                            {"cosine_variance", ".3e", "cosine"},
                            {"cltc_variance", ".3e", "CLTC"},
                            {"cosine_largest", ".3f", "largest"},
                            {"cltc_largest", ".3f", "CLTC's"}});
  rows.header(
      fmt::format("variance and largest weight of {} samples each, albedo 1; CLTC: with "
                  "the uniform hemisphere",
                  samples));
  Chart variances{.title = "Variance of the weight over the roughness, EON",
                  .subtitle = "lines: cosine; dots: CLTC and uniform",
                  .x_label = "\u03b8_o [degrees]",
                  .y_label = "variance",
                  .series = {},
                  .log_y = true};
  Chart largest = variances;
  largest.title = "Largest weight over the roughness, EON";
  largest.y_label = "largest weight";
  double peak[2] = {0, 0}, weight[2] = {0, 0}, smooth = 0;
  for (const double r : roughnesses) {
    if (is_set(context.stop)) return rows.rows();
    ChartSeries v[2], l[2];
    SamplerStatistics at[2];
    v[0] = l[0] = {.label = fmt::format("r = {:g}", r), .x = angles, .y = {}};
    v[1] = l[1] = {.label = "", .x = angles, .y = {}, .dots = true, .same_color = true};
    for (const double theta : angles) {
      for (const int k : {0, 1}) {
        const BoundModel model = figure_model(
            fmt::format("eon,albedo=1,roughness={},sampler={}", r, k ? "mis" : "cosine"));
        at[k] = sampler_statistics(*model.model, direction_from_degrees(theta, 0), samples,
                                   context.seed);
        v[k].y.push_back(at[k].variance);
        l[k].y.push_back(at[k].max_weight);
        if (r == 0) {
          smooth = std::max({smooth, at[k].variance, std::abs(at[k].max_weight - 1)});
        } else {
          peak[k] = std::max(peak[k], at[k].variance);
          weight[k] = std::max(weight[k], at[k].max_weight);
        }
      }
      rows.add({r, theta, at[0].variance, at[1].variance, at[0].max_weight, at[1].max_weight});
    }
    for (const int k : {0, 1}) {
      variances.series.push_back(std::move(v[k]));
      largest.series.push_back(std::move(l[k]));
    }
  }
  context.write("variance", variances);
  context.write("largest_weight", largest);
  context.find("at r = 0 both samplers have no variance and the weight 1",
               fmt::format("variance and largest weight less 1: {:.1e} at most", smooth),
               smooth < 1e-12);
  context.find("the peaks of variance and of the largest weight are much lower than the cosine's",
               fmt::format("variance {:.2e} and {:.2e}, weight {:.1f} and {:.1f}", peak[1], peak[0],
                           weight[1], weight[0]),
               peak[1] < 0.2 * peak[0] && weight[1] < 0.5 * weight[0]);
  return rows.rows();
}

Json reproduce_eon_table_1(ReproductionContext& context) {
  struct Timed {
    std::string name, request;
    double eval, cosine, cltc;  // the paper's, in nanoseconds; 0: none
  };
  const std::vector<Timed> list{
      {"Lambert", "lambert", 1.4, 67.2, 0},
      {"FON", "fon,roughness=0.5,sampler=cosine", 6.3, 67.2, 0},
      {"QON", "oren_nayar,sigma=0.8", 6.3, 67.4, 0},
      {"fullON", "oren_nayar_full,sigma=0.8", 141.7, 211.218, 0},
      {"EON (approx)", "eon_approx,roughness=0.5,sampler=cosine", 20.8, 105.8, 217.0},
      {"EON (exact)", "eon,roughness=0.5,sampler=cosine", 108.7, 193.5, 297.0}};
  const double seconds = context.by_quality(0.02, 0.3, 1.0);
  NumberRows rows(context, {{"model", "", "", 13},
                            {"eval_ns", ".1f", "eval"},
                            {"eval_paper", ".1f", "p. eval"},
                            {"cosine_ns", ".1f", "cosine"},
                            {"cosine_paper", ".1f", "p. cosine"},
                            {"cltc_ns", ".1f", "CLTC"},
                            {"cltc_paper", ".1f", "p. CLTC"}});
  rows.header(
      "nanoseconds on this machine and the paper's (p.); a sample includes the evaluation there; "
      "-: no "
      "such sampler");
  std::vector<SamplerTimes> cosine;
  double cltc_over_cosine = 0;
  for (const Timed& t : list) {
    context.go_on();
    const SamplerTimes times = sampler_times(*figure_model(t.request).model, seconds);
    cosine.push_back(times);
    double clipped = std::nan("");
    if (t.cltc > 0) {
      std::string request = t.request;
      request.replace(request.find("sampler=cosine"), 14, "sampler=mis");
      context.go_on();
      clipped = sampler_times(*figure_model(request).model, seconds).sample;
      if (cltc_over_cosine == 0) cltc_over_cosine = clipped / times.sample;
    }
    rows.add({t.name, times.eval, t.eval, times.sample, t.cosine, clipped,
              t.cltc > 0 ? t.cltc : std::nan("")});
  }
  const double full = cosine[3].eval, approx = cosine[4].eval, exact = cosine[5].eval;
  context.find("exact EON evaluates 1.3 times faster than fullON, approximate EON 7 times faster",
               fmt::format("{:.1f} and {:.1f} times faster", full / exact, full / approx),
               exact < full && approx < exact);
  context.find("CLTC sampling of approximate EON takes about twice as long as cosine sampling",
               fmt::format("{:.2f} times as long", cltc_over_cosine),
               cltc_over_cosine > 1 && cltc_over_cosine < 3);
  return rows.rows();
}

}  // namespace lamella
