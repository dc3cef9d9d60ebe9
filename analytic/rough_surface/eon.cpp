#include "analytic/rough_surface/eon.h"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "analytic/model/formula_model.h"
#include "analytic/model/one_half_space.h"
#include "analytic/rough_surface/oren_nayar.h"
#include "analytic/rough_surface/rough_surface_lanes.h"

namespace lamella {
namespace {

double fon_a(double roughness) { return 1 / (1 + kFonNormalLoss * roughness); }

/// The cosine-weighted mean of fon_loss: 1 - <E> = A r kMeanLoss.
constexpr double kMeanLoss = kFonNormalLoss - kFujiiMean;

/// Cosine-weighted mean of fon_loss_fit: a polynomial above the cosine at which the clamp ends.
double mean_loss_fit() {
  double low = 0, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (fon_loss_fit(middle) > 0 ? high : low) = middle;
  }
  const auto f = [](double mu) { return 2 * mu * (kFonNormalLoss - fujii_integral_fit(mu)); };
  return boost::math::quadrature::gauss<double, 7>::integrate(f, high, 1.0);
}

template <EonAlbedo kAlbedo>
EonFormula<kAlbedo> eon_formula(Rgb rho, double r) {
  const double a = fon_a(r), average = fon_average_albedo(r);
  EonFormula<kAlbedo> f{.single = {}, .multiple = {}, .roughness = r};
  for (int c = 0; c < 3; ++c) {
    f.single[c] = rho[c] * a / kPi;
    f.multiple[c] =
        rho[c] * rho[c] * average / (1 - rho[c] * (1 - average)) * a * r / (kPi * kMeanLoss);
  }
  return f;
}

template <EonAlbedo kAlbedo>
class Eon final : public FormulaModel<EonFormula<kAlbedo>> {
  using Base = FormulaModel<EonFormula<kAlbedo>>;
  using Base::formula_;

 public:
  Eon(Rgb rho, double roughness, BatchFunction<EonFormula<kAlbedo>> (*lanes_for)(Isa),
      HemisphereSampler sampler)
      : Base(kAlbedo == EonAlbedo::none ? 1 : 2, eon_formula<kAlbedo>(rho, roughness),
             rho.is_grey(), lanes_for),
        rho_(rho),
        roughness_(roughness),
        sampler_(sampler) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const auto s = formula_.shared(*a);
    return Base::per_channel([&](int c) {
      return lobe == 0 ? formula_.single[c] * s.single : formula_.multiple[c] * s.losses;
    });
  }

  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    const Rgb single = fon_albedo(wi.z, roughness_) * rho_;
    if constexpr (kAlbedo == EonAlbedo::none) return exact_albedo(single);
    static const double mean = kAlbedo == EonAlbedo::fit ? mean_loss_fit() : kMeanLoss;
    const double lost = kPi * mean * formula_.loss(wi.z);
    return exact_albedo(single +
                        Base::per_channel([&](int c) { return lost * formula_.multiple[c]; }));
  }

  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (wo.z < 0) return Model::sample(wo, u1, u2, u3);
    return frame_towards(wo).to_world(
        eon_sampling_lobe(wo.z, roughness_).sample(sampler_, u1, u2, u3));
  }

  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (wo.z < 0) return Model::pdf(wi, wo);
    return eon_sampling_lobe(wo.z, roughness_).pdf(sampler_, frame_towards(wo).to_local(wi));
  }

 private:
  Rgb rho_;
  double roughness_;
  HemisphereSampler sampler_;
};

template <EonAlbedo kAlbedo>
ModelInfo info(std::string name, std::string doc,
               BatchFunction<EonFormula<kAlbedo>> (*lanes_for)(Isa)) {
  std::vector<LobeInfo> lobes{{"ss", "Fujii's single scattering", Order::all}};
  if (kAlbedo != EonAlbedo::none)
    lobes.push_back({"ms", "the energy that single scattering loses", Order::all});
  return {.name = std::move(name),
          .doc = std::move(doc),
          .source =
              "Portsmouth, Kutz and Hill 2025, EON: A practical energy-preserving rough "
              "diffuse BRDF",
          .parameters = {albedo_parameter("albedo of the facets"),
                         {.name = "roughness",
                          .unit = "1",
                          .doc = "r; 0: Lambert",
                          .default_value = "0.5",
                          .min = 0,
                          .max = 1},
                         sampler_parameter()},
          .lobes = std::move(lobes),
          .make =
              [lanes_for](const Parameters& p, const Stack*) {
                return std::make_unique<Eon<kAlbedo>>(p.color("albedo"), p.number("roughness"),
                                                      lanes_for, sampler_of(p));
              },
          .applies_to = {}};
}

}  // namespace

double fon_albedo(double mu, double roughness) {
  return 1 - fon_a(roughness) * roughness * fon_loss(mu);
}

double fon_albedo_fit(double mu, double roughness) {
  return fon_a(roughness) * (1 + roughness * fujii_integral_fit(mu));
}

double fon_average_albedo(double roughness) {
  return fon_a(roughness) * (1 + roughness * kFujiiMean);
}

ClippedCosine eon_sampling_lobe(double mu, double r) {
  const double m = std::min(mu, 1.0);
  return {
      .a = 1 + r * (0.303392 + (-0.518982 + 0.111709 * m) * m + (-0.276266 + 0.335918 * m) * r),
      .b = r * (-1.16407 + 1.15859 * m + (0.150815 - 0.150105 * m) * r) / (m * m * m - 1.43545),
      .c = 1 + (0.20013 + (-0.506373 + 0.261777 * m) * m) * r,
      .d = r * (0.540852 + (-1.01625 + 0.475392 * m) * m) / (-1.0743 + m * (0.0725628 + m)),
      .uniform = std::pow(r, 0.1) * (0.162925 + m * (-0.372058 + (0.538233 - 0.290822 * m) * m))};
}

ModelInfo fon_model() {
  return info<EonAlbedo::none>("fon", "Fujii's Oren-Nayar model", fon_batch_for);
}

ModelInfo eon_model() {
  return info<EonAlbedo::exact>("eon", "energy-preserving Oren-Nayar model", eon_batch_for);
}

ModelInfo eon_approx_model() {
  return info<EonAlbedo::fit>(
      "eon_approx", "energy-preserving Oren-Nayar model with a fitted albedo", eon_fit_batch_for);
}

}  // namespace lamella
