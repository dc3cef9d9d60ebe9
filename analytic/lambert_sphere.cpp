#include "analytic/lambert_sphere.h"

#include <cmath>

#include "analytic/h_function.h"
#include "analytic/half_space.h"
#include "phase/lambert_sphere.h"

namespace lamella {
namespace {

/// What the models differ in: multiple scattering of one channel [1/sr].
template <class Multiple>
class LambertSphereModel final : public Model {
 public:
  explicit LambertSphereModel(Rgb albedo)
      : Model(2),
        albedo_(albedo),
        multiple_{Multiple(albedo.r), Multiple(albedo.g), Multiple(albedo.b)},
        channels_(albedo.is_grey() ? 1 : 3) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const double single = lambert_sphere_single(*a);
    if (lobe == 0) return single * albedo_;
    const auto at = [&](int c) { return multiple_[c](*a, single); };
    return channels_ == 1 ? Rgb(at(0)) : Rgb(at(0), at(1), at(2));
  }

 private:
  Rgb albedo_;
  std::array<Multiple, 3> multiple_;
  int channels_;
};

/// Eqs. 35, 45: modes 0 and 1 of three-term scattering without their order 1.
class Analytic {
 public:
  explicit Analytic(double albedo) : c_(albedo), w_(lambert_sphere_phase_terms(albedo)) {
    const double t2 = 1 - c_, t = std::sqrt(t2), t3 = t * t2;
    a_ = 69 * c_ / 128;
    b_ = (0.346689 * t3 - 0.777574 * t2 + 0.515357 * t - 0.084463) /
         (0.182602 * t2 - 0.665502 * t + 0.964893);
    c1_ = (-5602.45 * t3 + 7487.99 * t2 - 2567.74 * t + 682.848) /
          (1480.25 * t2 - 4008.33 * t + 5850.6);
    d_ = (166.883 * t3 - 327.428 * t2 + 160.397 * t + 0.285529) /
         (596.423 * t2 - 412.984 * t + 674.191);
    e_ = 15.0 / 128 * t2 * c_ * (4 * c_ / 3 + 3);
    f_ = (266.063 * t3 - 21.9141 * t2 - 242.16 * t - 1.9209) / (215.773 * t2 + 457.42 * t + 1499.9);
    l_ = (-0.00473696 * c_ - 0.0589037) * c_;
    const double m = 0.44038 * c_ + 1;
    n_ = l_ * l_ + 45 * m / 64;
  }

  [[nodiscard]] double operator()(const ReflectionAngles& a, double /*single*/) const {
    const double x = a.mu_i, y = a.mu_o, sum = x + y, product = x * y;
    const double f0 =
        lambert_sphere_h0(x, c_) * lambert_sphere_h0(y, c_) / (2 * kPi * sum) *
        (a_ + (b_ + d_ * product) * sum + (c1_ + e_ * product) * product + f_ * (x * x + y * y));
    const double f1 = c_ * lambert_sphere_h1(x, c_) * lambert_sphere_h1(y, c_) / (3 * kPi * sum) *
                      a.sin_i * a.sin_o * (1 + n_ * product + l_ * sum);
    return f0 - three_term_single(w_, 0, x, y) + (f1 - three_term_single(w_, 1, x, y)) * a.cos_phi;
  }

 private:
  double c_;
  ThreeTermPhase w_;
  double a_, b_, c1_, d_, e_, f_, l_, n_;
};

/// Eq. 48 without its f_1, so that the sum of both is its maximum with 0.
class Fast {
 public:
  explicit Fast(double albedo)
      : c_(albedo), base_(0.234459 * std::pow(lambert_sphere_bond_albedo(albedo), 1.85432)) {}

  [[nodiscard]] double operator()(const ReflectionAngles& a, double single) const {
    const double s = a.sin_i * a.sin_o;
    // S / (acos(S) + 0.113706 S) is the reciprocal of the printed denominator, finite at S = 0.
    const double slope = s / (std::acos(std::min(1.0, s)) + 0.113706 * s);
    const double f =
        base_ + 0.0151829 * (c_ - 0.249978) * (a.phi() + std::sqrt(a.mu_i * a.mu_o)) * slope;
    return std::max(-c_ * single, f);
  }

 private:
  double c_, base_;
};

class Hapke {
 public:
  explicit Hapke(double albedo) : c_(albedo) {}

  [[nodiscard]] double operator()(const ReflectionAngles& a, double /*single*/) const {
    const double product = isotropic_h_hapke_1981(a.mu_i, c_) * isotropic_h_hapke_1981(a.mu_o, c_);
    return c_ / (4 * kPi * (a.mu_i + a.mu_o)) * (product - 1);
  }

 private:
  double c_;
};

template <class Multiple>
ModelInfo info(std::string name, std::string doc, std::string source) {
  return {.name = std::move(name),
          .doc = std::move(doc),
          .source = std::move(source),
          .parameters = {albedo_parameter("albedo of the Lambertian spheres")},
          .lobes = {{"single", "one event", Order::one},
                    {"multiple", "two events and more", Order::all}},
          .make =
              [](const Parameters& p, const Stack*) {
                return std::make_unique<LambertSphereModel<Multiple>>(p.color("albedo"));
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

double lambert_sphere_single(const ReflectionAngles& a) {
  return lambert_sphere_phase(std::clamp(-(a.mu_i * a.mu_o + a.sines_cos), -1.0, 1.0)) /
         (a.mu_i + a.mu_o);
}

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

double lambert_sphere_h0(double mu, double albedo) {
  const double s = std::sqrt(1 - albedo);
  const double a = (1.50112 * std::pow(s, 6.05435) + 8.21644) / (4.17593 - 1.21222 * s);
  const double d =
      (7.7731 - 0.565811 * std::pow(s, 0.961546)) / (8.65912 - 0.159974 * std::pow(s, 7));
  const double power = a * std::pow(mu, d);
  // 1 / H0(infinity), 0 at c = 1
  const double limit = std::sqrt(three_term_k0(lambert_sphere_phase_terms(albedo), 0));
  return (1 + power) / (1 + power * limit);
}

double lambert_sphere_h1(double mu, double albedo) {
  const double e = ((-1.12831 * mu + 1.85728) * mu - 1.07879) * mu + 0.459442;
  return std::exp((0.0242851 * albedo - 0.144839) * albedo * std::pow(mu, e));
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
  return info<Analytic>("lambert_sphere", "half space of Lambertian spheres, analytic form",
                        kSource);
}

ModelInfo lambert_sphere_fast_model() {
  return info<Fast>("lambert_sphere_fast", "half space of Lambertian spheres, fast form", kSource);
}

ModelInfo hapke_lambert_sphere_model() {
  return info<Hapke>("hapke_lambert_sphere",
                     "Hapke's model with the phase function of the Lambertian sphere",
                     "Hapke 1981, Bidirectional reflectance spectroscopy: 1. Theory");
}

}  // namespace lamella
