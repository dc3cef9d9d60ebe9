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

constexpr int kTexels = 64;

// Filling factors of a square of texels: patches of dust of several sizes, from 0 to 0.95.
std::vector<double> dust() {
  std::vector<double> tau(kTexels * kTexels);
  for (int y = 0; y < kTexels; ++y)
    for (int x = 0; x < kTexels; ++x) {
      const double u = 2 * kPi * x / kTexels, v = 2 * kPi * y / kTexels;
      const double s = std::sin(2 * u + std::sin(3 * v)) * std::cos(3 * v - std::sin(u)) +
                       0.6 * std::sin(9 * u + 2 * std::cos(4 * v)) * std::sin(11 * v) +
                       0.4 * std::cos(23 * u) * std::cos(21 * v);
      tau[static_cast<std::size_t>(y) * kTexels + x] = 0.95 * std::clamp(0.5 + 0.5 * s, 0.0, 1.0);
    }
  return tau;
}

// Means over blocks of `block` x `block` texels.
template <class T>
std::vector<T> filtered(const std::vector<T>& texels, int block) {
  const int side = kTexels / block;
  std::vector<T> means(static_cast<std::size_t>(side) * side);
  for (int y = 0; y < kTexels; ++y)
    for (int x = 0; x < kTexels; ++x) {
      T& mean = means[static_cast<std::size_t>(y / block) * side + x / block];
      mean = mean + 1.0 / (block * block) * texels[static_cast<std::size_t>(y) * kTexels + x];
    }
  return means;
}

PreviewColumn picture_of(const std::string& name, const std::vector<Rgb>& blocks, int block) {
  constexpr int kScale = 2;
  const int size = kTexels * kScale, side = kTexels / block;
  PreviewColumn column{name,
                       {.width = size,
                        .height = size,
                        .radiance = {},
                        .covered = std::vector<bool>(static_cast<std::size_t>(size) * size, true)}};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      column.image.radiance.push_back(
          blocks[static_cast<std::size_t>(y / kScale / block) * side + x / kScale / block]);
  return column;
}

}  // namespace

Json reproduce_micrograin_figure_14(ReproductionContext& context) {
  struct Material {
    const char *name, *grains, *bulk;
  };
  const std::vector<Material> materials{
      {"moss", "surface=lambert,albedo=0.25,0.45,0.15,beta=0.9", "lambert,albedo=0.4"},
      {"dusty_wood", "surface=lambert,albedo=0.6,0.55,0.5,beta=0.5",
       "openpbr_diffuse,base_color=0.3,0.15,0.05,specular_roughness=0.2"},
      {"paint", "surface=conductor,f0=0.9,0.7,0.3,beta=0.3",
       "microfacet,material=conductor,roughness=0.5"}};
  // Grains at levels of the filling factor, over black; between them their f is taken as linear.
  const int levels = context.by_quality(24, 96, 384);
  NumberRows rows(context, {{"material", "", "", 11},
                            {"theta", "g"},
                            {"block", "g"},
                            {"relative_rmse", ".5f", "RMSE"},
                            {"mean", "+.5f"}});
  rows.header(
      "radiance of the filtered filling factor less the filtered radiance, lamp and viewer at "
      "theta "
      "on\nopposite sides, over blocks of texels: relative RMSE, and difference of the mean");
  const std::vector<double> tau = dust();
  double largest = 0, at_normal = 0;
  for (const Material& material : materials) {
    std::vector<BoundModel> models;
    for (int k = 0; k <= levels; ++k)
      models.push_back(figure_model(fmt::format("micrograin,{},tau0={},bulk=lambert,bulk_albedo=0",
                                                material.grains, 0.95 * k / levels)));
    const BoundModel bulk = figure_model(material.bulk);
    const double beta = models[0].parameters.number("beta");
    for (const double theta : {0.0, 45.0, 75.0}) {
      if (is_set(context.stop)) return rows.rows();
      const Direction wi = direction_from_degrees(theta, 0),
                      wo = direction_from_degrees(theta, 180);
      std::vector<Rgb> values;
      const Rgb below = bulk.model->eval(wi, wo);
      for (int k = 0; k <= levels; ++k) {
        const double w = micrograin_weight(wi.z, wo.z, 0.95 * k / levels, beta);
        values.push_back(kPi * wi.z * (models[k].model->eval(wi, wo) + (1 - w) * below));
      }
      const auto shaded = [&](const std::vector<double>& filling) {
        std::vector<Rgb> radiance;
        for (const double t : filling) {
          const double x = t / 0.95 * levels;
          const int k = std::min(levels - 1, static_cast<int>(x));
          radiance.push_back((1 - (x - k)) * values[k] + (x - k) * values[k + 1]);
        }
        return radiance;
      };
      const std::vector<Rgb> fine = shaded(tau);
      std::vector<PreviewColumn> columns;
      for (const int block : {1, 4, 16, 64}) {
        const std::vector<Rgb> parameters = shaded(filtered(tau, block));
        const std::vector<Rgb> radiances = filtered(fine, block);
        double square = 0, scale = 0, sum = 0, sum_true = 0;
        for (std::size_t k = 0; k < radiances.size(); ++k) {
          const double a = parameters[k].g, b = radiances[k].g;
          square += (a - b) * (a - b);
          scale += b * b;
          sum += a;
          sum_true += b;
        }
        const double rmse = std::sqrt(square / scale);
        rows.add({material.name, theta, static_cast<double>(block), rmse, sum / sum_true - 1});
        largest = std::max(largest, rmse);
        if (theta == 0 && material.grains[8] == 'l') at_normal = std::max(at_normal, rmse);
        columns.push_back(picture_of(fmt::format("tau0 over {}", block), parameters, block));
        columns.push_back(picture_of("radiance", radiances, block));
      }
      if (theta > 0)
        write_gallery(context, fmt::format("{}_{:g}", material.name, theta),
                      fmt::format("{}: filtered filling factor beside filtered radiance, {:g} "
                                  "degrees",
                                  material.name, theta),
                      columns);
    }
  }
  context.find("filling factors may be averaged for rendering at several scales",
               fmt::format("the radiance of the average is off by up to {:.1f} %", 100 * largest),
               largest < 0.1);
  context.find("the filling factor is the share of the area under grains",
               fmt::format("seen from above Lambertian grains are linear in it: {:.0e}", at_normal),
               at_normal < 2e-3);
  return rows.rows();
}

}  // namespace lamella
