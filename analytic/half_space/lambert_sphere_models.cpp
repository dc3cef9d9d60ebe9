#include "analytic/half_space/lambert_sphere_models.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analytic/half_space/half_space_lanes.h"
#include "analytic/model/formula_model.h"
#include "analytic/model/one_half_space.h"

namespace lamella {
namespace {

/// The models differ in their formula of multiple scattering.
template <class Formula>
class LambertSphereModel final : public FormulaModel<Formula> {
  using Base = FormulaModel<Formula>;
  using Base::formula_;

 public:
  LambertSphereModel(Rgb albedo, const Formula& formula, BatchFunction<Formula> (*lanes_for)(Isa))
      : Base(2, formula, albedo.is_grey(), lanes_for), albedo_(albedo) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    if (lobe == 0) return lambert_sphere_single_of(*a) * albedo_;
    const auto shared = formula_.shared(*a);
    return Base::per_channel([&](int c) { return formula_.multiple(shared, c); });
  }

 private:
  Rgb albedo_;
};

double h1_exponent(double albedo) { return (0.0242851 * albedo - 0.144839) * albedo; }

AnalyticLambertSphere::Channel channel_of(double c) {
  const ThreeTermPhase w = lambert_sphere_phase_terms(c);
  const double t2 = 1 - c, t = std::sqrt(t2), t3 = t * t2, l = (-0.00473696 * c - 0.0589037) * c;
  return {.albedo = c,
          .h0 = LambertSphereH0(c),
          .h1 = h1_exponent(c),
          .w1 = w[1],
          .w2 = w[2],
          .a = 69 * c / 128,
          .b = (0.346689 * t3 - 0.777574 * t2 + 0.515357 * t - 0.084463) /
               (0.182602 * t2 - 0.665502 * t + 0.964893),
          .c = (-5602.45 * t3 + 7487.99 * t2 - 2567.74 * t + 682.848) /
               (1480.25 * t2 - 4008.33 * t + 5850.6),
          .d = (166.883 * t3 - 327.428 * t2 + 160.397 * t + 0.285529) /
               (596.423 * t2 - 412.984 * t + 674.191),
          .e = 15.0 / 128 * t2 * c * (4 * c / 3 + 3),
          .f = (266.063 * t3 - 21.9141 * t2 - 242.16 * t - 1.9209) /
               (215.773 * t2 + 457.42 * t + 1499.9),
          .l = l,
          .n = l * l + 45 * (0.44038 * c + 1) / 64};
}

template <class Formula>
Formula formula_of(Rgb albedo);

template <>
AnalyticLambertSphere formula_of(Rgb albedo) {
  return lambert_sphere_formula(albedo);
}

template <>
FastLambertSphere formula_of(Rgb albedo) {
  FastLambertSphere f{};
  for (int c = 0; c < 3; ++c) {
    f.albedo[c] = albedo[c];
    f.base[c] = 0.234459 * std::pow(lambert_sphere_bond_albedo(albedo[c]), 1.85432);
    f.factor[c] = 0.0151829 * (albedo[c] - 0.249978);
  }
  return f;
}

template <>
HapkeLambertSphere formula_of(Rgb albedo) {
  HapkeLambertSphere f{};
  for (int c = 0; c < 3; ++c) {
    f.albedo[c] = albedo[c];
    f.root[c] = std::sqrt(1 - albedo[c]);
  }
  return f;
}

template <class Formula>
ModelInfo info(std::string name, std::string doc, std::string source,
               BatchFunction<Formula> (*lanes_for)(Isa)) {
  return {.name = std::move(name),
          .doc = std::move(doc),
          .source = std::move(source),
          .parameters = {albedo_parameter("albedo of the Lambertian spheres")},
          .lobes = {{"single", "one event", Order::one},
                    {"multiple", "two events and more", Order::all}},
          .make =
              [lanes_for](const Parameters& p, const Stack*) {
                const Rgb albedo = p.color("albedo");
                return std::make_unique<LambertSphereModel<Formula>>(
                    albedo, formula_of<Formula>(albedo), lanes_for);
              },
          .applies_to = lambert_sphere_parameters};
}

const char* const kSource =
    "d'Eon 2021, An analytic BRDF for materials with spherical Lambertian scatterers";

}  // namespace

std::optional<Parameters> lambert_sphere_parameters(const Stack& stack) {
  const Layer* layer = only_half_space(stack);
  if (layer && !std::holds_alternative<LambertSphere>(layer->medium)) return std::nullopt;
  // The limit of a bed of Lambertian spheres that are far apart, if it is deep.
  const GrainGeometry* bed = stack.grains();
  if (bed && bed->is_bed() && bed->surface == GrainSurface::lambert && !stack.substrate)
    layer = &stack.layers[0];
  if (!layer) return std::nullopt;
  Parameters p;
  p.set("albedo", layer->albedo);
  return p;
}

LambertSphereH0::LambertSphereH0(double albedo) {
  const double s = std::sqrt(1 - albedo);
  a = (1.50112 * std::pow(s, 6.05435) + 8.21644) / (4.17593 - 1.21222 * s);
  d = (7.7731 - 0.565811 * std::pow(s, 0.961546)) / (8.65912 - 0.159974 * std::pow(s, 7));
  limit = std::sqrt(three_term_k0(lambert_sphere_phase_terms(albedo), 0));
}

AnalyticLambertSphere lambert_sphere_formula(Rgb albedo) {
  return {.channels = {channel_of(albedo.r), channel_of(albedo.g), channel_of(albedo.b)}};
}

double lambert_sphere_single(const ReflectionAngles& a) { return lambert_sphere_single_of(a); }

double lambert_sphere_legendre(int k) {
  if (k == 0) return 1;
  if (k == 1) return -4.0 / 3;
  if (k % 2 == 1) return 0;
  double a = 0.25;  // a_2; (k + 4) a_(k+2) = -(k - 1) a_k
  for (int j = 2; j < k; j += 2) a *= -(j - 1.0) / (j + 4);
  return (2 * k + 1) * a * a;
}

ThreeTermPhase lambert_sphere_phase_terms(double albedo) {
  return {albedo, albedo * lambert_sphere_legendre(1), albedo * lambert_sphere_legendre(2)};
}

double lambert_sphere_h0(double mu, double albedo) { return LambertSphereH0(albedo)(std::log(mu)); }

double lambert_sphere_h1(double mu, double albedo) {
  return std::exp(h1_exponent(albedo) * lambert_sphere_h1_power(mu, std::log(mu)));
}

ThreeTermConstants exact_lambert_sphere_constants(double albedo) {
  // l and n are quotients of two terms that vanish with the albedo.
  return three_term_constants(
      ThreeTermHalfSpace(lambert_sphere_phase_terms(std::max(albedo, 1e-7))));
}

ThreeTermConstants fitted_lambert_sphere_constants(double albedo) {
  const AnalyticLambertSphere::Channel fit = channel_of(albedo);
  return {{fit.a, fit.b, fit.c, fit.d, fit.e, fit.f}, fit.l, three_term_m(fit.l, fit.n)};
}

double lambert_sphere_albedo(double bond_albedo) {
  const double k = 1 - bond_albedo;
  return (1 - std::pow(k, 2.73556)) / (1 - 0.184096 * std::pow(k, 2.48423));
}

double lambert_sphere_bond_albedo(double albedo) {
  const double s = std::sqrt(1 - albedo);
  return (1 - 0.453029 * (1 - albedo) - 0.544162 * s) / (1.42931 * s + 1);
}

ModelInfo lambert_sphere_model() {
  ModelInfo model = info<AnalyticLambertSphere>("lambert_sphere",
                                                "half space of Lambertian spheres, analytic form",
                                                kSource, lambert_sphere_batch_for);
  const auto of_albedo = [](double (*f)(double)) { return [f](double c, double) { return f(c); }; };
  const auto of_cosine = [](double (*f)(double, double)) {
    return [f](double c, double mu) { return f(mu, c); };
  };
  model.parts = {
      part_of_albedo("h0", "fitted H0 of w_i, eq. 37", of_cosine(lambert_sphere_h0)),
      part_of_albedo("h1", "fitted H1 of w_i, eq. 29", of_cosine(lambert_sphere_h1)),
      part_of_albedo("bond_albedo", "Bond albedo of the half space, eq. 47; of no direction",
                     of_albedo(lambert_sphere_bond_albedo)),
      part_of_albedo("albedo_map",
                     "particle albedo for the Bond albedo that is given as `albedo`, eq. 46; of no "
                     "direction",
                     of_albedo(lambert_sphere_albedo))};
  for (PartInfo& part : constant_parts("fitted", fitted_lambert_sphere_constants))
    model.parts.push_back(std::move(part));
  return model;
}

ModelInfo lambert_sphere_fast_model() {
  return info<FastLambertSphere>("lambert_sphere_fast",
                                 "half space of Lambertian spheres, fast form", kSource,
                                 fast_lambert_sphere_batch_for);
}

ModelInfo hapke_lambert_sphere_model() {
  return info<HapkeLambertSphere>(
      "hapke_lambert_sphere", "Hapke's model with the phase function of the Lambertian sphere",
      "Hapke 1981, Bidirectional reflectance spectroscopy: 1. Theory", hapke_batch_for);
}

}  // namespace lamella
