#include "analytic/micrograin.h"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "analytic/half_space.h"
#include "analytic/reflection_angles.h"
#include "phase/flake.h"

namespace lamella {
namespace {

double grains_per_disc(double tau0) { return -std::log1p(-tau0); }

/// lambda / tau0, 1 in the limit
double crowding(double tau0) { return tau0 == 0 ? 1 : grains_per_disc(tau0) / tau0; }

double tangent_squared(double mu) { return (1 - mu) * (1 + mu) / (mu * mu); }

/// gamma_beta(theta) / cos theta: area of a whole ellipsoid's shadow over that of its disc.
double shadow(double mu, double beta) { return std::sqrt(1 + beta * beta * tangent_squared(mu)); }

/// sin^2 / (beta^2 cos^2 + sin^2): the share of the disc inside of which normals are steeper.
double disc_share(double mu, double beta) {
  const double s2 = (1 - mu) * (1 + mu);
  return s2 / (beta * beta * mu * mu + s2);
}

double ggx_projected_area(double mu, double alpha) {
  return 0.5 * (mu + std::sqrt(mu * mu + alpha * alpha * (1 - mu) * (1 + mu)));
}

/// With tan theta_m = beta tan psi, D cos dm is lambda / tau0 exp(-lambda sin^2 psi) sin 2 psi dpsi
/// dphi / (2 pi). Up to psi = atan(mu / (beta sin)) every azimuth faces w; beyond, the azimuth is
/// integrated in closed form and psi by Gauss's rule, in a variable without the root at that end.
double smith_projected_area(double mu, double tau0, double beta) {
  const double s = std::sqrt((1 - mu) * (1 + mu));
  if (s == 0) return mu;
  const double lambda = grains_per_disc(tau0);
  const double start = std::atan2(mu, beta * s);
  const double y0 = std::pow(std::sin(start), 2);
  const double facing = tau0 == 0 ? y0 : -std::expm1(-lambda * y0) / tau0;
  const double width = kPi / 2 - start;
  const auto integrand = [&](double v) {
    const double psi = start + width * v * v;
    const double sine = std::sin(psi), cosine = std::cos(psi);
    const double a = mu * cosine, b = s * beta * sine;
    const double phi = std::acos(std::max(-1.0, -a / b));
    return (a * phi + std::sqrt(std::max(0.0, (b - a) * (b + a)))) * sine *
           std::exp(-lambda * sine * sine) * 2 * width * v;
  };
  const double beyond = boost::math::quadrature::gauss<double, 40>::integrate(integrand, 0.0, 1.0);
  return mu * facing + 2 / kPi * crowding(tau0) * beyond;
}

struct Grains {
  double tau0, beta;
  bool conductor;
  MicrograinShadowing shadowing;
  Rgb albedo, f0, bulk;
};

class Micrograin final : public Model {
 public:
  explicit Micrograin(const Grains& grains) : Model(2), g_(grains) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const double w = micrograin_weight(a->mu_i, a->mu_o, g_.tau0, g_.beta);
    if (lobe == 1) return (1 - w) / kPi * g_.bulk;
    return g_.conductor ? w * specular(*a, wi, wo) : w / kPi * g_.albedo;
  }

  /// Lambertian parts by the cosine law, conductors by their normals (section 4.3). A reflected
  /// direction may lie below, where the model is 0: the density counts it.
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (wo.z < 0 || u1 >= specular_probability(wo)) return Model::sample(wo, u2, u3, u1);
    const double mu = micrograin_ndf_sample(u2, g_.tau0, g_.beta);
    return mirrored(wo, direction_from_mu_phi(mu, 2 * kPi * u3));
  }

  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (wo.z < 0) return Model::pdf(wi, wo);
    const double p = specular_probability(wo);
    double density = p < 1 ? (1 - p) * Model::pdf(wi, wo) : 0;
    if (p > 0) {
      const Direction h = normalized(half_vector(wi, wo));
      const double cosine = std::abs(dot(wo, h)), mu = std::abs(h.z);
      if (cosine > 0) density += p * micrograin_ndf(mu, g_.tau0, g_.beta) * mu / (4 * cosine);
    }
    return density;
  }

 private:
  [[nodiscard]] double specular_probability(Direction wo) const {
    if (!g_.conductor) return 0;
    if (g_.bulk == Rgb()) return 1;
    return micrograin_tau_plus(std::max(wo.z, kGrazingLimit), g_.tau0, g_.beta);
  }

  [[nodiscard]] Rgb specular(const ReflectionAngles& a, Direction wi, Direction wo) const {
    const Direction h = normalized(half_vector(wi, wo));
    const double pi = micrograin_projected_area(a.mu_i, g_.tau0, g_.beta, g_.shadowing);
    const double po = micrograin_projected_area(a.mu_o, g_.tau0, g_.beta, g_.shadowing);
    // G / (mu_i mu_o), which is finite at grazing
    const double shadowing = 1 / (a.mu_o * pi + a.mu_i * po - a.mu_i * a.mu_o);
    return micrograin_ndf(h.z, g_.tau0, g_.beta) / 4 * shadowing *
           schlick(g_.f0, schlick_weight(dot(wi, h)));
  }

  Grains g_;
};

ParameterInfo color(std::string name, std::string doc, std::string default_value) {
  ParameterInfo info = albedo_parameter(std::move(doc));
  info.name = std::move(name);
  info.default_value = std::move(default_value);
  return info;
}

/// A part that is a function of one cosine.
template <class F>
auto of_cosines(const F& f) {
  return [f](const Parameters& p, Direction wi, Direction wo) {
    return Rgb(f(std::max(std::abs(wi.z), kGrazingLimit), std::max(std::abs(wo.z), kGrazingLimit),
                 p.number("tau0"), p.number("beta")));
  };
}

}  // namespace

double micrograin_ndf(double mu, double tau0, double beta) {
  const double s2 = (1 - mu) * (1 + mu), q = beta * beta * mu * mu + s2;
  return crowding(tau0) * beta * beta / (kPi * q * q) * std::exp(-grains_per_disc(tau0) * s2 / q);
}

double micrograin_ndf_cdf(double mu, double tau0, double beta) {
  const double y = disc_share(mu, beta);
  return tau0 == 0 ? y : -std::expm1(-grains_per_disc(tau0) * y) / tau0;
}

double micrograin_ndf_sample(double xi, double tau0, double beta) {
  const double y = tau0 == 0 ? xi : std::log1p(-xi * tau0) / std::log1p(-tau0);
  return std::sqrt((1 - y) / (1 - y + beta * beta * y));
}

double micrograin_equivalent_roughness(double tau0, double beta) {
  return beta / std::sqrt(crowding(tau0));
}

double micrograin_tau(double mu, double tau0, double beta) {
  return -std::expm1(-grains_per_disc(tau0) * shadow(mu, beta));
}

double micrograin_tau_plus(double mu, double tau0, double beta) {
  return -std::expm1(-grains_per_disc(tau0) * (1 + shadow(mu, beta)) / 2);
}

double micrograin_weight(double mu_i, double mu_o, double tau0, double beta) {
  const double area = (shadow(mu_i, beta) + shadow(mu_o, beta)) / 2;
  return -std::expm1(-grains_per_disc(tau0) * area);
}

double micrograin_projected_area(double mu, double tau0, double beta,
                                 MicrograinShadowing shadowing) {
  return shadowing == MicrograinShadowing::ggx
             ? ggx_projected_area(mu, micrograin_equivalent_roughness(tau0, beta))
             : smith_projected_area(mu, tau0, beta);
}

ModelInfo micrograin_model() {
  return {
      .name = "micrograin",
      .doc = "porous layer of opaque half ellipsoids on a Lambertian surface",
      .source = "Lucas et al. 2023, A Micrograin BSDF Model for the Rendering of Porous Layers",
      .parameters =
          {{.name = "tau0",
            .unit = "1",
            .doc = "filling factor: share of the surface under grains",
            .default_value = "0.5",
            .min = 0,
            .max = 1,
            .max_open = true},
           {.name = "beta",
            .unit = "1",
            .doc = "anfractuosity: height of a grain over its radius",
            .default_value = "0.5",
            .min = 0.001,
            .max = 1},
           {.name = "surface",
            .kind = ParameterKind::choice,
            .unit = "1",
            .doc = "surface of a grain",
            .default_value = "lambert",
            .choices = {"lambert", "conductor"}},
           color("albedo", "of Lambertian grains", "1"),
           color("f0", "reflectance of conductors at normal incidence (Schlick)", "1"),
           color("bulk_albedo", "of the Lambertian surface below", "0"),
           {.name = "shadowing",
            .kind = ParameterKind::choice,
            .unit = "1",
            .doc = "ggx: Smith's of GGX with the equivalent roughness; smith: of the exact normals",
            .default_value = "ggx",
            .choices = {"ggx", "smith"}}},
      .lobes = {{"grains", "light that meets grains", Order::all},
                {"bulk", "light that meets the surface below only", Order::all}},
      .make =
          [](const Parameters& p, const Stack*) {
            return std::make_unique<Micrograin>(
                Grains{.tau0 = p.number("tau0"),
                       .beta = p.number("beta"),
                       .conductor = p.choice("surface") == "conductor",
                       .shadowing = p.choice("shadowing") == "smith" ? MicrograinShadowing::smith
                                                                     : MicrograinShadowing::ggx,
                       .albedo = p.color("albedo"),
                       .f0 = p.color("f0"),
                       .bulk = p.color("bulk_albedo")});
          },
      .applies_to = {},
      .parts = {{"ndf", "D of the normal w_i [1/sr]",
                 of_cosines([](double mu_i, double, double tau0, double beta) {
                   return micrograin_ndf(mu_i, tau0, beta);
                 })},
                {"tau_plus", "visible filling factor from w_i",
                 of_cosines([](double mu_i, double, double tau0, double beta) {
                   return micrograin_tau_plus(mu_i, tau0, beta);
                 })},
                {"weight", "share of the paths between w_i and w_o that meet grains",
                 of_cosines(micrograin_weight)}}};
}

}  // namespace lamella
