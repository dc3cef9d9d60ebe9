#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/rough_surface/eon.h"
#include "compare/reproduce/eon_figures.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// The paper's texts give no colours.
constexpr const char* kBrown = "0.6,0.4,0.25";

// How sharply f bends where the azimuths differ by 90 degrees (s = 0): the change of df / dphi
// there, over f, as the mean over pairs of cosines with equal projected solid angles.
double bend(const Model& model) {
  constexpr int kCosines = 16;
  constexpr double kStep = 1e-5;
  double sum = 0;
  for (int i = 0; i < kCosines; ++i)
    for (int o = 0; o < kCosines; ++o) {
      const double mu_i = std::sqrt((i + 0.5) / kCosines), mu_o = std::sqrt((o + 0.5) / kCosines);
      const auto f = [&](double phi) {
        return model.eval(direction_from_mu_phi(mu_i, 0), direction_from_mu_phi(mu_o, phi)).g;
      };
      const double middle = f(kPi / 2);
      const double before = (middle - f(kPi / 2 - kStep)) / kStep;
      const double after = (f(kPi / 2 + kStep) - middle) / kStep;
      sum += std::abs(after - before) / middle;
    }
  return sum / (kCosines * kCosines);
}

double covered_mean(const PreviewColumn& column, double* least, double* most) {
  double sum = 0, count = 0;
  *least = 1e300;
  *most = 0;
  for (std::size_t k = 0; k < column.image.radiance.size(); ++k) {
    if (!column.image.covered[k]) continue;
    const double v = column.image.radiance[k].g;
    sum += v;
    ++count;
    *least = std::min(*least, v);
    *most = std::max(*most, v);
  }
  return sum / count;
}

// A model alone under a lamp and in a furnace.
struct LampAndFurnace {
  Json rows;
  double mean, least, most;  // of the furnace's picture
  double bend, bend_of_oren_nayar;
};

LampAndFurnace lamp_and_furnace(ReproductionContext& context, const std::string& label,
                                const std::string& model) {
  const BoundModel brown = figure_model(fmt::format("{},albedo={}", model, kBrown));
  const BoundModel white = figure_model(model + ",albedo=1");
  const BoundModel oren_nayar = figure_model(fmt::format("oren_nayar,albedo=1,sigma={}", kPi / 2));
  const std::vector<PreviewColumn> lit{
      lit_sphere("Lambert", *figure_model(fmt::format("lambert,albedo={}", kBrown)).model),
      lit_sphere(label, *brown.model)};
  write_spheres(context, "lamp", label + " under a lamp at 45 degrees", lit);
  const std::vector<PreviewColumn> furnace{
      sphere_of("all energy kept", [](Direction) { return Rgb(1); }),
      furnace_sphere(label, *white.model)};
  write_spheres(context, "furnace", label + " in a white furnace", furnace);
  LampAndFurnace result{};
  result.mean = covered_mean(furnace[1], &result.least, &result.most);
  result.bend = bend(*white.model);
  result.bend_of_oren_nayar = bend(*oren_nayar.model);
  NumberRows rows(context, {{"model", "", "", 14},
                            {"furnace_mean", ".6f", "furnace"},
                            {"furnace_least", ".6f", "least"},
                            {"furnace_most", ".6f", "most"},
                            {"bend", ".4f"},
                            {"lamp_luminance", ".4f", "lamp"},
                            {"lambert_luminance", ".4f", "Lambert"}});
  rows.header(
      "furnace: mean radiance of the picture, which is the average albedo; bend: change of df / "
      "dphi over f\nwhere the azimuths differ by 90 degrees, mean; luminances under the lamp");
  rows.add({label, result.mean, result.least, result.most, result.bend, luminance_of(lit[1]).mean,
            luminance_of(lit[0]).mean});
  result.rows = rows.rows();
  return result;
}

// f of one lobe of a model.
PreviewColumn lit_lobe(const std::string& name, const Model& model, int lobe) {
  return lit_sphere(
      name,
      [&model, lobe](Direction wo) {
        return [&model, lobe, wo](Direction wi) { return model.eval_lobe(lobe, wi, wo); };
      },
      sphere_view(kSphereLamp));
}

}  // namespace

Json reproduce_eon_figure_1(ReproductionContext& context) {
  const BoundModel lambert = figure_model("lambert,albedo=0.8");
  const BoundModel oren_nayar =
      figure_model(fmt::format("oren_nayar,albedo=0.8,sigma={}", kPi / 2));
  const BoundModel eon = figure_model("eon,albedo=0.8,roughness=1");
  NumberRows rows(context, {{"lamp", "g"},
                            {"model", "", "", 10},
                            {"luminance", ".4f"},
                            {"rim", ".4f"},
                            {"relative_rmse", ".4f", "RMSE"}});
  rows.header(
      fmt::format("albedo 0.8 at the highest roughness; mean luminance of the sphere, of "
                  "its rim (mu_o < {:g});\nrelative RMSE from Lambert",
                  kRimCosine));
  double mean[2][3], rim[2][3];
  for (const int side : {0, 1}) {
    const PreviewView view = sphere_view(side ? 90 : 30);
    const std::vector<PreviewColumn> columns{lit_sphere("Lambert", *lambert.model, view),
                                             lit_sphere("QON", *oren_nayar.model, view),
                                             lit_sphere("EON", *eon.model, view)};
    for (int k = 0; k < 3; ++k) {
      const SphereLuminance l = luminance_of(columns[k]);
      mean[side][k] = l.mean;
      rim[side][k] = l.rim;
      rows.add({view.lamp_theta, columns[k].name, l.mean, l.rim,
                difference(columns[k], columns[0]).rmse});
    }
    write_spheres(context, side ? "side" : "front",
                  fmt::format("highest roughness, lit from the {}", side ? "side" : "front"),
                  columns);
  }
  context.find("EON has a brightness like Lambert's where the QON model loses energy",
               fmt::format("from the front QON has {:.2f} and EON {:.2f} of Lambert's mean, from "
                           "the side {:.2f} and {:.2f}",
                           mean[0][1] / mean[0][0], mean[0][2] / mean[0][0],
                           mean[1][1] / mean[1][0], mean[1][2] / mean[1][0]),
               std::abs(mean[0][2] / mean[0][0] - 1) < std::abs(mean[0][1] / mean[0][0] - 1) &&
                   std::abs(mean[1][2] / mean[1][0] - 1) < std::abs(mean[1][1] / mean[1][0] - 1));
  context.find("rough surfaces look flatter, with less darkening of the edge",
               fmt::format("from the front the rim has {:.2f} of Lambert's mean luminance, {:.2f} "
                           "of QON's, {:.2f} of EON's",
                           rim[0][0] / mean[0][0], rim[0][1] / mean[0][1], rim[0][2] / mean[0][2]),
               rim[0][1] / mean[0][1] > rim[0][0] / mean[0][0] &&
                   rim[0][2] / mean[0][2] > rim[0][0] / mean[0][0]);
  return rows.rows();
}

Json reproduce_eon_figure_4(ReproductionContext& context) {
  const std::string sigma = fmt::format(",albedo={},sigma={}", kBrown, kPi / 2);
  const std::string rough = fmt::format(",albedo={},roughness=1", kBrown);
  const std::vector<std::pair<std::string, std::string>> list{
      {"Lambert", fmt::format("lambert,albedo={}", kBrown)},
      {"fullON", "oren_nayar_full" + sigma},
      {"QON", "oren_nayar" + sigma},
      {"footnote QON", "oren_nayar_footnote" + sigma},
      {"Fujii QON", "fujii_qualitative" + sigma},
      {"FON", "fon" + rough},
      {"EON", "eon" + rough}};
  NumberRows rows(context, {{"model", "", "", 14},
                            {"luminance", ".4f"},
                            {"rim", ".4f"},
                            {"saturation", ".4f"},
                            {"from_full", ".4f", "from full"}});
  rows.header(
      "highest roughness; mean luminance, that of the rim, mean red over mean blue, relative RMSE "
      "from fullON");
  std::vector<PreviewColumn> columns;
  for (const auto& [name, request] : list)
    columns.push_back(lit_sphere(name, *figure_model(request).model));
  std::vector<double> means;
  for (const PreviewColumn& c : columns) {
    const SphereLuminance l = luminance_of(c);
    means.push_back(l.mean);
    rows.add({c.name, l.mean, l.rim, saturation(c), difference(c, columns[1]).rmse});
  }
  write_spheres(context, "models", "highest roughness, lamp at 45 degrees", columns);
  context.find("EON is brighter than the other Oren-Nayar models",
               fmt::format("mean luminance {:.4f}; the brightest of the others has {:.4f}",
                           means.back(), *std::max_element(means.begin() + 1, means.end() - 1)),
               means.back() > *std::max_element(means.begin() + 1, means.end() - 1));
  context.find("EON shifts the colour: multiple scattering is more saturated",
               fmt::format("mean red over blue {:.3f}, of Lambert {:.3f}, of FON {:.3f}",
                           saturation(columns[6]), saturation(columns[0]), saturation(columns[5])),
               saturation(columns[6]) > saturation(columns[5]));
  return rows.rows();
}

Json reproduce_eon_figure_5(ReproductionContext& context) {
  const LampAndFurnace r =
      lamp_and_furnace(context, "QON", fmt::format("oren_nayar,sigma={}", kPi / 2));
  context.find(
      "QON loses a significant amount of energy in the furnace",
      fmt::format("{:.1f} % on average, {:.1f} % at most", 100 * (1 - r.mean), 100 * (1 - r.least)),
      r.mean < 0.9);
  context.find("a dark ring shows where s = 0",
               fmt::format("f bends there: df / dphi changes by {:.3f} of f per radian", r.bend),
               r.bend > 0.05);
  return r.rows;
}

Json reproduce_eon_figure_8(ReproductionContext& context) {
  const LampAndFurnace r = lamp_and_furnace(context, "FON", "fon,roughness=1");
  const LampAndFurnace* of = &r;
  context.find("FON fixes the ring",
               fmt::format("f still bends where s = 0, by {:.3f} of f per "
                           "radian, QON's bend is {:.3f}",
                           of->bend, of->bend_of_oren_nayar),
               of->bend < 0.5 * of->bend_of_oren_nayar);
  const double qon =
      luminance_of(
          furnace_sphere("QON",
                         *figure_model(fmt::format("oren_nayar,albedo=1,sigma={}", kPi / 2)).model))
          .mean;
  context.find("FON does better in the furnace than QON but loses energy away from grazing",
               fmt::format("average {:.4f}, QON {:.4f}; at the normal {:.4f}, at the rim {:.4f}",
                           r.mean, qon, fon_albedo(1, 1), fon_albedo(0.01, 1)),
               r.mean > qon && fon_albedo(1, 1) < 0.9 && fon_albedo(0.01, 1) > 0.99);
  return r.rows;
}

Json reproduce_eon_figure_9(ReproductionContext& context) {
  const LampAndFurnace r = lamp_and_furnace(context, "EON", "eon,roughness=1");
  context.find("EON passes the white furnace",
               fmt::format("between 1 {:+.1e} and 1 {:+.1e}", r.least - 1, r.most - 1),
               std::abs(r.least - 1) < 1e-6 && std::abs(r.most - 1) < 1e-6);
  context.find("EON inherits FON's cure of the ring",
               fmt::format("f bends where s = 0 by {:.3f} of f per radian, QON's bend is {:.3f}",
                           r.bend, r.bend_of_oren_nayar),
               r.bend < 0.5 * r.bend_of_oren_nayar);
  return r.rows;
}

Json reproduce_eon_figure_10(ReproductionContext& context) {
  NumberRows rows(context, {{"color", "", "", 14},
                            {"single", ".4f"},
                            {"multiple", ".4f"},
                            {"share", ".4f"},
                            {"single_saturation", ".4f", "sat. ss"},
                            {"multiple_saturation", ".4f", "sat. ms"},
                            {"total_saturation", ".4f", "sat. EON"}});
  rows.header("r = 1: luminance of the two lobes, the second's share; red over blue of the means");
  bool saturated = true;
  double bright = 0, dark = 0;
  for (const std::string color : {"0.95,0.8,0.6", "0.8,0.5,0.2", "0.3,0.2,0.1"}) {
    const BoundModel eon = figure_model(fmt::format("eon,roughness=1,albedo={}", color));
    const BoundModel qon =
        figure_model(fmt::format("oren_nayar,sigma={},albedo={}", kPi / 2, color));
    const std::vector<PreviewColumn> columns{
        lit_sphere("EON", *eon.model), lit_sphere("QON", *qon.model),
        lit_lobe("EON, single", *eon.model, 0), lit_lobe("EON, multiple", *eon.model, 1)};
    const double ss = luminance_of(columns[2]).mean, ms = luminance_of(columns[3]).mean;
    rows.add({color, ss, ms, ms / (ss + ms), saturation(columns[2]), saturation(columns[3]),
              saturation(columns[0])});
    saturated = saturated && saturation(columns[3]) > saturation(columns[2]);
    if (bright == 0) bright = ms / (ss + ms);
    dark = ms / (ss + ms);
    write_spheres(context, fmt::format("color_{}", rows.rows().size()), "albedo " + color, columns);
  }
  // White EON times the colour has the colour of single scattering.
  const BoundModel white = figure_model("eon,roughness=1,albedo=1");
  const Rgb color(0.8, 0.5, 0.2);
  const PreviewColumn tinted = lit_sphere(
      "white times colour",
      [&](Direction wo) {
        return [&, wo](Direction wi) { return color * white.model->eval(wi, wo); };
      },
      sphere_view(kSphereLamp));
  context.find("multiple scattering adds saturation",
               "red over blue is higher in the multiple lobe for all three colours", saturated);
  context.find("the shift matters for high albedos",
               fmt::format("multiple scattering is {:.1f} % of the brightest colour's luminance, "
                           "{:.1f} % of the darkest's",
                           100 * bright, 100 * dark),
               bright > dark);
  context.find("white EON times the colour has no shift",
               fmt::format("red over blue {:.6f}, the colour's own is {:.6f}", saturation(tinted),
                           color.r / color.b),
               std::abs(saturation(tinted) / (color.r / color.b) - 1) < 1e-12);
  return rows.rows();
}

}  // namespace lamella
