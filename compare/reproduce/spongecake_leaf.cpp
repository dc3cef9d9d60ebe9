#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/layered/single_scattering_model.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/spongecake_figures.h"
#include "compare/reproduce/spongecake_scenes.h"
#include "compare/reproduce/traced_scene.h"
#include "compare/truth/ground_truth.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// The best two lobes of the leaf at depth 1 with flakes along its normal, as `lamella fit` finds
// them. They are factors of the layers' own numbers.
constexpr const char* kLobes =
    "spongecake,second_weight=1,lambert_transmit=0.00129,0,0.00129,second_roughness_1=4.017,"
    "second_depth_1=6.955,second_albedo_1=0.06465,0.1061,0.02486,second_f0_1=0,0,0.1821,"
    "second_roughness_2=0.5489,second_depth_2=0.3081,second_albedo_2=1.096,2.293,0.5098,"
    "second_roughness_3=14.96,second_depth_3=101.1,second_albedo_3=3.437,6.336,1.193,"
    "second_f0_3=0.04328,0.1437,0.003926";

constexpr double kThinnest = 0.3, kThickest = 2;

// Depth of the leaf: a rib in the middle, veins that leave it, and clouds between.
double leaf_depth(double u, double v) {
  const double across = std::abs(u - 0.5);
  const double rib = std::exp(-std::pow(across / 0.012, 2));
  const double vein = std::pow(0.5 + 0.5 * std::cos(2 * kPi * (9 * v - 7 * across)), 24);
  const double depth = 0.8 + 0.25 * wavy(u, v, 6, 3) + 1.2 * rib + 0.6 * vein;
  return std::clamp(depth, kThinnest, kThickest);
}

// The normals of the flakes: the leaf is a little rough.
Direction leaf_axis(double u, double v) {
  return normalized(Direction{0.12 * wavy(u, v, 9, 11), 0.12 * wavy(u, v, 9, 12), 1});
}

std::string top_mirror(Direction axis) {
  return flake_layer("surface", axis, 0.05, Rgb(1), 0.1, 0.05);
}

// The paper's table has no colour of the leaf; this green is chosen here.
std::string leaf_text_at(Direction axis, double depth) {
  return top_mirror(axis) +
         fmt::format(
             "[[layer]]\nmedium = \"henyey_greenstein\"\ng = 0.7\nalbedo = [0.6, 0.9, "
             "0.35]\nthickness = {}\n",
             depth) +
         flake_layer("surface", axis, 0.05, Rgb(1), 1, 0.002);
}

std::string leaf_text(double u, double v) {
  return leaf_text_at(leaf_axis(u, v), leaf_depth(u, v));
}

// Half a leaf to either side of its rib, bent.
TriangleMesh leaf() {
  return patch(128, 128, [](double u, double v) {
    const double t = std::clamp(v, 0.0, 1.0);
    const double half = 0.55 * std::pow(std::sin(kPi * t), 0.8) * (1.25 - 0.5 * t) + 0.004;
    const double x = (2 * u - 1) * half;
    return Direction{x, 2 * v - 1, 0.35 * std::abs(x) - 0.25 * (2 * v - 1) * (2 * v - 1)};
  });
}

// Light from the normal that leaves on either side after scattering, by the leaf's depth.
class LeafEnergies {
 public:
  explicit LeafEnergies(const ReproductionContext& context) {
    for (std::size_t k = 0; k < kDepths; ++k) {
      TruthRequest request{.stack = figure_stack("leaf", leaf_text_at({0, 0, 1}, depth(k)))};
      request.directions = {{0, 0, 1}};
      request.estimator = Estimator::analog;
      request.given = {WalkSetting::walks};
      request.effort.walks = context.by_quality<std::uint64_t>(2048, 262144, 4194304);
      request.seed = context.seed;
      request.isa = isa_from_text("auto");
      const RunResult run = GroundTruth(request, Estimator::analog, {}).find(0).run;
      for (int c = 0; c < 3; ++c) {
        reflected_[k][c] = run.reflected.multiple[static_cast<std::size_t>(c)].value;
        transmitted_[k][c] = run.transmitted.total[static_cast<std::size_t>(c)].value;
      }
    }
  }
  [[nodiscard]] Rgb reflected(double d) const { return at(reflected_, d); }
  [[nodiscard]] Rgb transmitted(double d) const { return at(transmitted_, d); }

 private:
  static constexpr std::size_t kDepths = 6;
  static double depth(std::size_t k) {
    return kThinnest + (kThickest - kThinnest) * static_cast<double>(k) / (kDepths - 1);
  }
  static Rgb at(const std::array<Rgb, kDepths>& values, double d) {
    const double x = (d - kThinnest) / (kThickest - kThinnest) * (kDepths - 1);
    const auto k = std::min(static_cast<std::size_t>(std::max(0.0, x)), kDepths - 2);
    const double t = x - static_cast<double>(k);
    return (1 - t) * values[k] + t * values[k + 1];
  }
  std::array<Rgb, kDepths> reflected_, transmitted_;
};

// The common alternative: the mirrors in front, and lobes of constant radiance with the leaf's
// energies on both sides.
class LambertLeaf final : public Model {
 public:
  LambertLeaf(Direction axis, Rgb reflected, Rgb transmitted)
      : Model(1),
        mirror_(figure_stack("mirror", top_mirror(axis))),
        reflected_(reflected),
        transmitted_(transmitted) {}

  [[nodiscard]] Rgb eval_lobe(int, Direction wi, Direction wo) const override {
    if ((wi.z > 0) != (wo.z > 0)) return 1 / kPi * transmitted_;
    return 1 / kPi * reflected_ + mirror_.eval(wi, wo);
  }
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    return mirror_.sample(wo, u1, u2, u3);
  }
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    return mirror_.pdf(wi, wo);
  }

 private:
  SingleScatteringModel mirror_;
  Rgb reflected_, transmitted_;
};

}  // namespace

Json reproduce_spongecake_figure_18(ReproductionContext& context) {
  const ViewedObject object(leaf());
  const auto truth = walked_texture(leaf_text);
  const auto single = closed_texture(leaf_text, "spongecake,lobes=none");
  // The network knows flakes alone.
  const auto fitted = closed_texture(leaf_text, kLobes);
  const LeafEnergies energies(context);
  constexpr int kPlaces = 128;
  const auto lambert =
      closed_surface({kPlaces, kPlaces,
                      [&](double u, double v) -> std::unique_ptr<Model> {
                        const double d = leaf_depth(u, v);
                        return std::make_unique<LambertLeaf>(leaf_axis(u, v), energies.reflected(d),
                                                             energies.transmitted(d));
                      }},
                     true);
  NumberRows rows(context, {{"light", "", "", 6},
                            {"picture", "", "", 24},
                            {"luminance", ".4f"},
                            {"bright", ".3f", "brightest"},
                            {"bias", ".4f", "bias^2"},
                            {"flip", ".4f", "FLIP"}});
  rows.header(
      "a leaf: mean luminance, the brightest per cent over the mean, relative mean square error "
      "without noise and FLIP from the truth by walks");
  const int samples = context.by_quality(32, 256, 4096);
  std::array<double, 2> of_truth{}, of_lambert{}, of_fit{}, bright_truth{};
  for (const auto& [side, lamp] : {std::pair("front", normalized(Direction{0.62, 0, 0.78})),
                                   std::pair("back", normalized(Direction{0.12, -0.1, -0.99}))}) {
    const std::size_t k = side == std::string("back");
    const LightDome light(SkyKind::none, lamp);
    std::vector<NamedPicture> pictures;
    for (const NamedSurface& s :
         {NamedSurface{"truth", truth.get()}, NamedSurface{"SpongeCake", fitted.get()},
          NamedSurface{"single scattering", single.get()},
          NamedSurface{"Lambertian lobes", lambert.get()}}) {
      if (is_set(context.stop)) return rows.rows();
      pictures.push_back(traced(context, s.name, object, light, *s.surface, samples));
      const PathPicture& p = pictures.back().picture;
      const TracedError error = traced_error(pictures.front().picture, p);
      const PictureLuminance l = luminance_of(p);
      rows.add({side, s.name, l.mean, l.bright / l.mean, error.bias, error.flip});
      if (s.name == "truth") of_truth[k] = l.mean, bright_truth[k] = l.bright / l.mean;
      if (s.name == "SpongeCake") of_fit[k] = error.bias;
      if (s.name == "Lambertian lobes") of_lambert[k] = l.mean;
    }
    write_traced(context, side, fmt::format("leaf, lit from the {}", side), pictures, true);
  }
  context.find(
      "light from behind is strongly peaked, which a Lambertian lobe cannot have: it is "
      "much darker in transmission",
      fmt::format("lit from behind, the Lambertian lobe of the same energy is {:.2f} times "
                  "as bright as the truth",
                  of_lambert[1] / of_truth[1]),
      of_lambert[1] < 0.6 * of_truth[1]);
  context.find("light from the front has specular reflection",
               fmt::format("the brightest per cent is {:.1f} times the mean in front, {:.1f} times "
                           "behind",
                           bright_truth[0], bright_truth[1]),
               bright_truth[0] > bright_truth[1]);
  context.find("three layers describe the leaf",
               fmt::format("relative mean square error without noise {:.3f} in front, {:.3f} "
                           "behind, with the best two lobes for one depth",
                           of_fit[0], of_fit[1]),
               std::max(of_fit[0], of_fit[1]) < 0.1);
  return rows.rows();
}

}  // namespace lamella
