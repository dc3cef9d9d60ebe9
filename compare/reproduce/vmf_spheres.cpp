#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/half_space/vmf_diffuse.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/uniform_light.h"
#include "compare/reproduce/vmf_figures.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

BoundModel vmf(double roughness, Rgb albedo) {
  return figure_model(fmt::format("vmf_diffuse,roughness={},albedo={},{},{}", roughness, albedo.r,
                                  albedo.g, albedo.b));
}

Rgb remapped(Rgb color, double roughness) {
  return {vmf_diffuse_albedo(color.r, roughness), vmf_diffuse_albedo(color.g, roughness),
          vmf_diffuse_albedo(color.b, roughness)};
}

// Smooth random numbers in [0, 1] over space, some `cells` to a unit: lattice values that a hash
// makes, blended.
double noise(Direction p, double cells, std::uint32_t seed) {
  const auto value = [&](int x, int y, int z) {
    std::uint32_t h = seed;
    for (const int v : {x, y, z}) {
      h ^= static_cast<std::uint32_t>(v) + 0x9e3779b9U + (h << 6) + (h >> 2);
      h *= 0x85ebca6bU;
      h ^= h >> 13;
    }
    return (h >> 8) / 16777216.0;
  };
  const double at[] = {p.x * cells + 64, p.y * cells + 64, p.z * cells + 64};
  int cell[3];
  double t[3];
  for (int k = 0; k < 3; ++k) {
    cell[k] = static_cast<int>(at[k]);
    const double u = at[k] - cell[k];
    t[k] = u * u * (3 - 2 * u);
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    for (int k = 0; k < 3; ++k) weight *= (corner >> k) & 1 ? t[k] : 1 - t[k];
    sum += weight * value(cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1),
                          cell[2] + ((corner >> 2) & 1));
  }
  return sum;
}

}  // namespace

Json reproduce_vmf_figure_1(ReproductionContext& context) {
  // The caption's.
  const Rgb color(0.518, 0.331, 0.184);
  // The solver's time goes with the channels.
  const Rgb sand = context.quality == Quality::draft ? Rgb(color.g) : color;
  constexpr double kRoughness = 0.5;
  const Stack stack = figure_stack(
      "sand", fmt::format("[[layer]]\nmedium = \"vmf_flake\"\nroughness = {}\nalbedo = [{}, {}, "
                          "{}]\nthickness = inf\n",
                          kRoughness, sand.r, sand.g, sand.b));
  const LobeTable truth = solved_table(stack, context);
  const BoundModel model = vmf(kRoughness, sand);
  // As bright under uniform light.
  const BoundModel lambert =
      figure_model(with_bond_albedo("lambert", quick_average_albedo(*model.model)));
  NumberRows rows(context, {{"light", "", "", 10},
                            {"lamp", "g"},
                            {"solver", ".5f"},
                            {"model", ".5f", "vmf_diffuse"},
                            {"lambert", ".5f", "Lambert"},
                            {"relative_rmse", ".4f", "RMSE"}});
  rows.header(
      "albedo (0.518, 0.331, 0.184), r = 0.5: mean luminance of a sphere; relative RMSE of the "
      "closed form;\nLambert's albedo reflects as much of uniform light");
  double ratio[3], worst = 0;
  const std::array<std::pair<const char*, double>, 3> lights{
      {{"front", 0}, {"side", 90}, {"back", 140}}};
  for (int k = 0; k < 3; ++k) {
    const PreviewView view = sphere_view(lights[k].second);
    const std::vector<PreviewColumn> columns{lit_sphere("solver", truth, view),
                                             lit_sphere("vmf_diffuse", *model.model, view),
                                             lit_sphere("Lambert", *lambert.model, view)};
    const double error = difference(columns[1], columns[0]).rmse;
    worst = std::max(worst, error);
    double mean[3];
    for (int c = 0; c < 3; ++c) mean[c] = luminance_of(columns[c]).mean;
    ratio[k] = mean[0] / mean[2];
    rows.add({lights[k].first, lights[k].second, mean[0], mean[1], mean[2], error});
    write_spheres(context, lights[k].first, fmt::format("sand, lit from the {}", lights[k].first),
                  columns);
  }
  context.find(
      "changes of brightness from side to side come from the BRDF itself",
      fmt::format("over a Lambertian sphere the luminance is {:.2f} from the front, {:.2f} from "
                  "the side, {:.2f} from the back",
                  ratio[0], ratio[1], ratio[2]),
      std::max({ratio[0], ratio[1], ratio[2]}) > 1.1 * std::min({ratio[0], ratio[1], ratio[2]}));
  context.find("the closed form stands for the medium",
               fmt::format("relative RMSE of the pictures up to {:.1f} %", 100 * worst),
               worst < 0.1);
  return rows.rows();
}

Json reproduce_vmf_figure_7(ReproductionContext& context) {
  const std::vector<double> colors = context.quality == Quality::draft
                                         ? std::vector<double>{0.5}
                                         : std::vector<double>{0.2, 0.4, 0.6, 0.8, 0.95};
  const int levels = context.by_quality(6, 24, 48), cosines = context.by_quality(6, 24, 48);
  NumberRows rows(context, {{"albedo", "g"},
                            {"least", ".4f"},
                            {"most", ".4f"},
                            {"remapped_least", ".4f", "rem. least"},
                            {"remapped_most", ".4f", "rem. most"},
                            {"off", ".4f"},
                            {"remapped_off", ".4f", "rem. off"}});
  rows.header(
      "share of uniform light that is reflected along the normal, least and most over the "
      "roughness; mean\ndistance from the albedo that is asked for; both without and with the "
      "remapping (rem.)");
  double off = 0, off_remapped = 0;
  std::vector<PreviewColumn> original, corrected;
  for (const double c : colors) {
    if (is_set(context.stop)) return rows.rows();
    double least[2] = {1, 1}, most[2] = {0, 0}, distance[2] = {0, 0};
    for (const int which : {0, 1}) {
      // Albedo by roughness and cosine.
      std::vector<double> table((levels + 1) * (cosines + 1));
      for (int level = 0; level <= levels; ++level) {
        const double r = level / static_cast<double>(levels);
        const BoundModel model = vmf(r, which ? remapped(Rgb(c), r) : Rgb(c));
        for (int k = 0; k <= cosines; ++k)
          table[level * (cosines + 1) + k] =
              quick_albedo(*model.model, std::max(1e-3, k / static_cast<double>(cosines))).g;
        const double normal = table[level * (cosines + 1) + cosines];
        least[which] = std::min(least[which], normal);
        most[which] = std::max(most[which], normal);
        distance[which] += std::abs(normal - c) / (levels + 1);
      }
      (which ? corrected : original)
          .push_back(
              sphere_of(fmt::format("{} {:g}", which ? "remapped" : "albedo", c), [&](Direction n) {
                double turn = std::atan2(n.y, n.x) / (2 * kPi);
                if (turn < 0) turn += 1;
                const double x = turn * levels, y = n.z * cosines;
                const int i = std::min(levels - 1, static_cast<int>(x));
                const int k = std::min(cosines - 1, static_cast<int>(y));
                const auto at = [&](int a, int b) { return table[a * (cosines + 1) + b]; };
                const double s = x - i, t = y - k;
                return Rgb((1 - s) * ((1 - t) * at(i, k) + t * at(i, k + 1)) +
                           s * ((1 - t) * at(i + 1, k) + t * at(i + 1, k + 1)));
              }));
    }
    off += distance[0] / static_cast<double>(colors.size());
    off_remapped += distance[1] / static_cast<double>(colors.size());
    rows.add({c, least[0], most[0], least[1], most[1], distance[0], distance[1]});
  }
  write_gallery(context, "original", "roughness from 0 to 1 around the sphere, uniform light",
                original, 1.0);
  write_gallery(context, "remapped", "the same with the remapped albedo", corrected, 1.0);
  context.find("spheres grow darker with the roughness, and the remapping makes up for it",
               fmt::format("the normal's albedo is off by {:.4f} on average, remapped by {:.4f}",
                           off, off_remapped),
               off_remapped < 0.5 * off);
  return rows.rows();
}

Json reproduce_vmf_figure_8(ReproductionContext& context) {
  constexpr int kLevels = 33;
  const Rgb color(0.5);
  std::vector<BoundModel> models;
  for (int k = 0; k < kLevels; ++k) {
    const double r = k / (kLevels - 1.0);
    models.push_back(vmf(r, remapped(color, r)));
  }
  const auto roughness_at = [&](Direction n) {
    const double v = 0.65 * noise(n, 4, 7) + 0.35 * noise(n, 11, 19);
    return std::clamp((v - 0.25) / 0.5, 0.0, 1.0);
  };
  NumberRows rows(context, {{"lamp", "g"},
                            {"luminance", ".4f"},
                            {"smooth", ".4f"},
                            {"rough", ".4f"},
                            {"correlation", "+.4f"}});
  rows.header(
      "albedo remapped to 0.5; lamp: degrees from the viewer; radiance of the smoothest and of the "
      "roughest\nthird of the patches over the mean of all roughnesses at the same place; "
      "correlation of roughness\nand that ratio");
  std::vector<PreviewColumn> columns{
      sphere_of("roughness", [&](Direction n) { return Rgb(roughness_at(n)); })};
  double least = 1, most = -1;
  for (const double lamp : {0.0, 30.0, 60.0, 90.0, 120.0, 150.0}) {
    if (is_set(context.stop)) return rows.rows();
    const Direction light = direction_from_degrees(lamp, 0);
    std::vector<double> levels, ratios;
    columns.push_back(sphere_of(fmt::format("lamp at {:g}", lamp), [&](Direction n) {
      const double mu_i = dot(n, light);
      if (mu_i <= 0) return Rgb();
      // The azimuth between the directions as seen along n.
      const Direction a = light - mu_i * n, b = Direction{0, 0, 1} - n.z * n;
      const double lengths = std::sqrt(dot(a, a) * dot(b, b));
      const double phi = lengths > 0 ? std::acos(std::clamp(dot(a, b) / lengths, -1.0, 1.0)) : 0;
      const Direction wi = direction_from_mu_phi(mu_i, 0), wo = direction_from_mu_phi(n.z, phi);
      double mean = 0;
      for (int k = 0; k < kLevels; k += 4) mean += models[k].model->eval(wi, wo).g / 9;
      const double r = roughness_at(n);
      const int level = static_cast<int>(std::lround(r * (kLevels - 1)));
      const Rgb f = models[level].model->eval(wi, wo);
      levels.push_back(r);
      ratios.push_back(f.g / mean);
      return kPi * mu_i * f;
    }));
    double mr = 0, mv = 0, rr = 0, vv = 0, rv = 0, ends[2] = {0, 0}, counts[2] = {0, 0};
    const auto count = static_cast<double>(levels.size());
    for (std::size_t k = 0; k < levels.size(); ++k) {
      mr += levels[k] / count;
      mv += ratios[k] / count;
    }
    for (std::size_t k = 0; k < levels.size(); ++k) {
      rr += (levels[k] - mr) * (levels[k] - mr);
      vv += (ratios[k] - mv) * (ratios[k] - mv);
      rv += (levels[k] - mr) * (ratios[k] - mv);
      if (levels[k] > 1.0 / 3 && levels[k] < 2.0 / 3) continue;
      const int end = levels[k] >= 2.0 / 3;
      ends[end] += ratios[k];
      ++counts[end];
    }
    const double correlation = rv / std::sqrt(rr * vv);
    least = std::min(least, correlation);
    most = std::max(most, correlation);
    rows.add({lamp, luminance_of(columns.back()).mean, ends[0] / counts[0], ends[1] / counts[1],
              correlation});
  }
  write_gallery(context, "turning", "a texture of roughness under a lamp that turns", columns, 1.0);
  context.find("different patches flare up at different times",
               fmt::format("roughness and relative radiance correlate by {:+.2f} to {:+.2f} as the "
                           "lamp turns",
                           least, most),
               least < -0.1 && most > 0.1);
  return rows.rows();
}

Json reproduce_vmf_figure_10(ReproductionContext& context) {
  const Rgb color(0.9, 0.4, 0.2);  // the caption's
  const std::vector<double> roughnesses{0, 0.25, 0.5, 0.75, 1};
  const auto request = [&](const std::string& name, double r) {
    return fmt::format("{},sigma={},albedo=0.9,0.4,0.2", name, r * kPi / 2);
  };
  NumberRows rows(context, {{"roughness", "g"},
                            {"model", "", "", 13},
                            {"luminance", ".4f"},
                            {"saturation", ".4f"},
                            {"white", ".4f"},
                            {"from_vmf", ".4f", "from vMF"}});
  rows.header(
      "albedo (0.9, 0.4, 0.2), sigma = r pi / 2: mean luminance, red over blue, share of uniform "
      "light that\nthe white model reflects, relative RMSE from vmf_diffuse");
  const std::array<std::string, 4> names{"fullON", "QON", "vmf_diffuse", "remapped"};
  std::array<std::vector<PreviewColumn>, 4> pictures;
  double worst_white = 0, off[2] = {0, 0}, near[5] = {}, on_white = 1;
  double plain[2], mapped[2];
  for (std::size_t k = 0; k < roughnesses.size(); ++k) {
    const double r = roughnesses[k];
    std::array<BoundModel, 4> models{figure_model(request("oren_nayar_full", r)),
                                     figure_model(request("oren_nayar", r)), vmf(r, color),
                                     vmf(r, remapped(color, r))};
    const std::array<BoundModel, 3> white{
        figure_model(fmt::format("oren_nayar_full,albedo=1,sigma={}", r * kPi / 2)),
        figure_model(fmt::format("oren_nayar,albedo=1,sigma={}", r * kPi / 2)), vmf(r, Rgb(1))};
    for (std::size_t m = 0; m < models.size(); ++m)
      pictures[m].push_back(lit_sphere(fmt::format("{}, r = {:g}", names[m], r), *models[m].model));
    for (std::size_t m = 0; m < models.size(); ++m) {
      const PreviewColumn& picture = pictures[m].back();
      const double energy = m < 3 ? quick_average_albedo(*white[m].model).g : std::nan("");
      const double distance = difference(picture, pictures[2].back()).rmse;
      rows.add({r, names[m], luminance_of(picture).mean, saturation(picture), energy, distance});
      if (m == 0) near[k] = distance;
      if (m < 2) on_white = std::min(on_white, energy);
      if (m == 2) worst_white = std::max(worst_white, std::abs(energy - 1));
    }
    if (r == 0 || r == 1) {
      plain[r == 1] = saturation(pictures[2].back());
      mapped[r == 1] = saturation(pictures[3].back());
    }
    off[0] += std::abs(saturation(pictures[2].back()) / 4.5 - 1) / 5;
    off[1] += std::abs(saturation(pictures[3].back()) / 4.5 - 1) / 5;
  }
  for (std::size_t m = 0; m < names.size(); ++m)
    write_spheres(context, names[m], names[m] + " over the roughness", pictures[m]);
  const PreviewColumn spheres = lit_sphere(
      "Lambert spheres", *figure_model("lambert_sphere_three_term,albedo=0.9,0.4,0.2").model);
  const double from_spheres = difference(pictures[2].back(), spheres).rmse;
  context.find(
      "Oren-Nayar and vmf_diffuse are identical at r = 0, similar at low roughness, and "
      "diverge",
      fmt::format("relative RMSE {:.1e}, {:.3f}, {:.3f}, {:.3f}, {:.3f} at r = 0 to 1", near[0],
                  near[1], near[2], near[3], near[4]),
      near[0] < 1e-9 && near[4] > near[1]);
  context.find("Oren-Nayar loses energy as it grows rough",
               fmt::format("white models reflect down to {:.3f}", on_white), on_white < 0.95);
  context.find("vmf_diffuse preserves energy",
               fmt::format("the white closed form reflects 1 within {:.3f}", worst_white),
               worst_white < 0.02);
  context.find("saturation rises with the roughness, the remapping compensates",
               fmt::format("red over blue from {:.2f} to {:.2f}, remapped from {:.2f} to {:.2f}",
                           plain[0], plain[1], mapped[0], mapped[1]),
               plain[1] > plain[0] && off[1] < off[0]);
  context.find("at r = 1 the model closely approximates the Lambert-sphere BRDF",
               fmt::format("relative RMSE of the pictures {:.1f} %", 100 * from_spheres),
               from_spheres < 0.05);
  return rows.rows();
}

}  // namespace lamella
