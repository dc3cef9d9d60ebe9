#include <fmt/format.h>
#include <fmt/ranges.h>

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

double ggx_lambda(double mu, double alpha) {
  const double tan2 = (1 - mu * mu) / (mu * mu);
  return (std::sqrt(1 + alpha * alpha * tan2) - 1) / 2;
}

// The mixture of d'Eon et al. by eq. 26: GGX facets and a bulk with the weight 1 - (1 - w_A)^(1/G).
PreviewColumn deon_sphere(const std::string& name, double tau0, double alpha, const Model& facets,
                          const Model& bulk) {
  return lit_sphere(
      name,
      [&, tau0, alpha](Direction wo) {
        return [&, tau0, alpha, wo](Direction wi) {
          if (!(wi.z > 0 && wo.z > 0)) return Rgb();
          const double inverse = 1 + ggx_lambda(wi.z, alpha) + ggx_lambda(wo.z, alpha);
          const double w = 1 - std::pow(1 - tau0, inverse);
          return w * facets.eval(wi, wo) + (1 - w) * bulk.eval(wi, wo);
        };
      },
      sphere_view(kSphereLamp));
}

}  // namespace

Json reproduce_micrograin_figure_12(ReproductionContext& context) {
  // The paper's text gives no colours: white metal over a blue Lambertian bulk.
  const std::string bulk = "0.1,0.2,0.6";
  const BoundModel base = figure_model("lambert,albedo=" + bulk);
  NumberRows rows(context, {{"tau0", "g"},
                            {"beta", "g"},
                            {"alpha", ".4f"},
                            {"luminance", ".4f"},
                            {"deon", ".4f", "d'Eon"},
                            {"relative_rmse", ".4f", "RMSE"},
                            {"from_ggx", ".4f", "from GGX"}});
  rows.header(
      "metallic grains over a blue bulk under a lamp at 45 degrees: mean luminances; relative RMSE "
      "of this\nmodel from d'Eon's mixture, and from GGX alone");
  double least = 1e9, most = 0, tau_most = 0, alpha_most = 0;
  bool nearer = true;
  for (const double tau0 : {0.2, 0.6, 0.95})
    for (const double beta : {0.2, 0.5, 0.9}) {
      if (is_set(context.stop)) return rows.rows();
      const double alpha = micrograin_equivalent_roughness(tau0, beta);
      const BoundModel facets = figure_model(
          fmt::format("microfacet,material=white,distribution=ggx,roughness={}", alpha));
      const BoundModel grains = figure_model(fmt::format(
          "micrograin,surface=conductor,f0=1,tau0={},beta={},bulk=lambert,bulk_albedo={}", tau0,
          beta, bulk));
      const std::vector<PreviewColumn> columns{
          deon_sphere("d'Eon et al.", tau0, alpha, *facets.model, *base.model),
          lit_sphere("micrograin", *grains.model), lit_sphere("GGX alone", *facets.model)};
      const double distance = difference(columns[1], columns[0]).rmse;
      const double from_ggx = difference(columns[1], columns[2]).rmse;
      rows.add({tau0, beta, alpha, luminance_of(columns[1]).mean, luminance_of(columns[0]).mean,
                distance, from_ggx});
      write_spheres(context, fmt::format("tau_{:g}_beta_{:g}", tau0, beta),
                    fmt::format("metallic grains, tau0 = {:g}, beta = {:g}", tau0, beta), columns);
      least = std::min(least, distance);
      if (distance > most) most = distance, tau_most = tau0, alpha_most = alpha;
      nearer = nearer && distance < from_ggx;
    }
  context.find("the differences from d'Eon's model are subtle",
               fmt::format("relative RMSE {:.1f} % to {:.1f} %, less than from GGX alone: {}",
                           100 * least, 100 * most, nearer ? "always" : "not always"),
               most < 0.25 && nearer);
  context.find(
      "they show up mainly for large tau0 and small equivalent roughness",
      fmt::format("the largest is at tau0 {:g}, equivalent roughness {:.3f}", tau_most, alpha_most),
      tau_most > 0.9 && alpha_most < 0.2);
  return rows.rows();
}

namespace {

// A sphere of glass as its surface shows it: what it passes of a lamp inside, 20 degrees off the
// axis of view, which refraction shows within the disc.
PreviewColumn seen_through(const std::string& name, const Model& model) {
  const Direction lamp = direction_from_degrees(160, 0);
  return sphere_of(name, [&](Direction n) {
    const Frame<double> frame = frame_around(n);
    const Direction wi = frame.to_local(lamp), wo = frame.to_local(Direction{0, 0, 1});
    if (!(wi.z < 0) || !(wo.z > 0)) return Rgb();
    return -kPi * wi.z * model.eval(wi, wo);
  });
}

}  // namespace

Json reproduce_micrograin_figure_13(ReproductionContext& context) {
  struct Kind {
    const char *name, *request;
    double beta;
  };
  const std::vector<Kind> grains{
      {"diffuse", "surface=lambert,albedo=0.7,0.5,0.3", 0.9},
      {"diffuse and specular", "surface=dielectric,ior=1.5,albedo=0.7,0.5,0.3", 0.5},
      {"metal", "surface=conductor,f0=0.95,0.8,0.4", 0.3}};
  const std::vector<std::pair<const char*, std::string>> bulks{
      {"diffuse", "bulk=lambert,bulk_albedo=0.1,0.3,0.5"},
      {"plastic", "bulk=openpbr_diffuse,bulk_base_color=0.1,0.3,0.5,bulk_specular_roughness=0.15"},
      {"metal", "bulk=microfacet,bulk_material=conductor,bulk_roughness=0.2"},
      {"glass", "bulk=microfacet,bulk_material=dielectric,bulk_ior=1.5,bulk_roughness=0.1"}};
  constexpr double kTau0 = 0.5;  // the paper's
  NumberRows rows(context, {{"grains", "", "", 21},
                            {"bulk", "", "", 8},
                            {"luminance", ".4f"},
                            {"bare", ".4f"},
                            {"rim", ".4f"},
                            {"grains_at_normal", ".4f", "normal"},
                            {"grains_at_grazing", ".4f", "grazing"}});
  rows.header(
      "tau0 = 0.5, lamp at 45 degrees: mean luminance with grains and of the bare bulk, that of "
      "the "
      "rim; share\nof the paths that meet grains at normal incidence and at 80 degrees");
  bool grows = true;
  int changed = 0, cases = 0;
  std::vector<std::string> transparency;
  double clearest = 0;
  for (const auto& [bulk_name, bulk] : bulks) {
    // The tables of plastic and metal take seconds.
    if (context.quality == Quality::draft && cases > 0) break;
    const BoundModel bare =
        figure_model(fmt::format("micrograin,surface=lambert,albedo=0,tau0=0,beta=0.5,{}", bulk));
    std::vector<PreviewColumn> columns{lit_sphere(fmt::format("bare {}", bulk_name), *bare.model)};
    for (const Kind& kind : grains) {
      if (is_set(context.stop)) return rows.rows();
      const BoundModel model = figure_model(
          fmt::format("micrograin,{},tau0={},beta={},{}", kind.request, kTau0, kind.beta, bulk));
      columns.push_back(lit_sphere(kind.name, *model.model));
      const SphereLuminance l = luminance_of(columns.back());
      const double grazing = std::cos(80 * kPi / 180);
      const double normal = micrograin_weight(1, 1, kTau0, kind.beta);
      const double low = micrograin_weight(grazing, grazing, kTau0, kind.beta);
      rows.add({kind.name, bulk_name, l.mean, luminance_of(columns[0]).mean, l.rim, normal, low});
      grows = grows && low > normal;
      changed += difference(columns.back(), columns[0]).rmse > 0.05;
      ++cases;
    }
    write_spheres(context, bulk_name, fmt::format("grains over {}, tau0 = 0.5", bulk_name),
                  columns);
    if (bulk_name != std::string("glass")) continue;
    // The same glass with the lamp behind it.
    std::vector<PreviewColumn> passed{seen_through("bare glass", *bare.model)};
    for (const Kind& kind : grains) {
      const BoundModel model = figure_model(
          fmt::format("micrograin,{},tau0={},beta={},{}", kind.request, kTau0, kind.beta, bulk));
      passed.push_back(seen_through(kind.name, *model.model));
      const double left = luminance_of(passed.back()).mean / luminance_of(passed[0]).mean;
      transparency.push_back(fmt::format("{:.3f} ({})", left, kind.name));
      clearest = std::max(clearest, left);
    }
    write_gallery(context, "through_glass", "the glass with the lamp behind it, tau0 = 0.5",
                  passed);
  }
  context.find("grains hide the bulk at grazing angles",
               "the share of the paths that meet grains is higher at 80 degrees for every kind",
               grows);
  if (!transparency.empty())
    context.find("grains reduce the transparency of the bulk",
                 fmt::format("of the light that bare glass passes there is {}",
                             fmt::join(transparency, ", ")),
                 clearest < 1 - kTau0 + 0.01);
  context.find(
      "every kind of grain over every bulk gives a look of its own",
      fmt::format("{} of {} pictures differ from the bare bulk by more than 5 %", changed, cases),
      changed == cases);
  return rows.rows();
}

}  // namespace lamella
