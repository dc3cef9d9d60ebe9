#include "analytic/layered/micrograin.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "analytic/model/models_below.h"
#include "analytic/model/one_half_space.h"
#include "analytic/model/parameter_infos.h"
#include "analytic/model/reflection_angles.h"
#include "phase/grains/grain_geometry.h"
#include "phase/math/sampling.h"
#include "phase/medium/flake.h"
#include "phase/surface/fresnel.h"

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

/// mu plus the integral over the facets that face away, term by term (see the header). R and the
/// sines are times the sine of w, so that nothing is infinite at normal incidence.
double series_projected_area(double mu, double tau0, double beta, int terms) {
  const double lambda = grains_per_disc(tau0);
  const double s = std::sqrt((1 - mu) * (1 + mu));
  const double r = std::hypot(beta * s, mu);
  const double sine = beta * s / r, cosine = mu / r;  // of A
  // The integral of sin^(2n + 1) over (0, A), by its recurrence; J_n = sine sin^(2n + 1) A /
  // (2n + 1) - cosine times it.
  double integral = cosine < 0.5 ? 1 - cosine : sine * sine / (1 + cosine);
  double power = sine;      // sin^(2n + 1) A
  double factor = kPi / 2;  // lambda^n / n! B_n
  double sum = 0;
  for (int n = 0;; ++n) {
    const double term = factor * (sine * power / (2 * n + 1) - cosine * integral);
    sum += term;
    // Terms grow up to n = lambda at most and fall by lambda sin^2 A / n from there.
    if (n == terms || (n > lambda && std::abs(term) <= 1e-17 * sum)) break;
    power *= sine * sine;
    integral = ((2 * n + 2) * integral - power * cosine / sine) / (2 * n + 3);
    factor *= (n + 1.5) / (n + 2) * lambda / (n + 1);
    if (!(sine > 0)) break;
  }
  const double scale = lambda > 0 ? lambda / std::expm1(lambda) : 1;
  return mu + scale * r / kPi * std::max(0.0, sum);
}

struct Grains {
  double tau0, beta, ior;
  GrainSurface surface;
  MicrograinShadowing shadowing;
  int terms;
  bool visible_normals;
  Rgb albedo, f0;
  std::shared_ptr<const Model> bulk;
  bool bulk_transmits;
};

/// What a specular grain's part loses, 1 - E, as a function of mu: cubics between nodes that crowd
/// below beta, where E changes from that of single facets to that of grains which shadow each
/// other.
class SpecularLoss {
 public:
  SpecularLoss() = default;
  template <class Albedo>
  SpecularLoss(double beta, const Albedo& albedo)
      : scale_(kCrowding * beta), range_(std::asinh(1 / scale_)) {
    for (int k = 0; k < kNodes; ++k)
      loss_[k] = 1 - albedo(std::clamp(mu_at(k * kStep), kGrazingLimit, 1.0));
    // The mean of what operator() gives: 2 mu dmu.
    using Rule = boost::math::quadrature::gauss<double, 8>;
    for (int k = 0; k + 1 < kNodes; ++k)
      mean_ += Rule::integrate(
          [&](double x) {
            const double slope = range_ * scale_ * std::cosh(x * range_);
            return 2 * mu_at(x) * slope * at(x);
          },
          k * kStep, (k + 1) * kStep);
  }
  [[nodiscard]] double operator()(double mu) const { return at(std::asinh(mu / scale_) / range_); }
  [[nodiscard]] double mean() const { return mean_; }

 private:
  static constexpr int kNodes = 65;
  static constexpr double kStep = 1.0 / (kNodes - 1);
  static constexpr double kCrowding = 0.25;

  [[nodiscard]] double mu_at(double x) const { return scale_ * std::sinh(x * range_); }

  // Lagrange's cubic through four nodes, two on each side where there are.
  [[nodiscard]] double at(double x) const {
    const double place = std::clamp(x / kStep, 0.0, kNodes - 1.0);
    const int k = std::clamp(static_cast<int>(place) - 1, 0, kNodes - 4);
    const double u = place - k, v = u - 1, w = u - 2, z = u - 3;
    return (v * w * z * -loss_[k] + 3 * (u * w * z * loss_[k + 1] - u * v * z * loss_[k + 2]) +
            u * v * w * loss_[k + 3]) /
           6;
  }

  double scale_ = 1, range_ = 1;
  std::array<double, kNodes> loss_{};
  double mean_ = 0;
};

class Micrograin final : public Model {
 public:
  explicit Micrograin(const Grains& grains) : Model(2), g_(grains) {
    if (g_.surface == GrainSurface::dielectric)
      loss_ = SpecularLoss(g_.beta, [&](double mu) { return specular_albedo(mu); });
  }

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    if (wi.z < 0 || wo.z < 0) return from_below(lobe, wi, wo);
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    wi = with_grazing_limit(wi);
    wo = with_grazing_limit(wo);
    const double w = micrograin_weight(a->mu_i, a->mu_o, g_.tau0, g_.beta);
    if (lobe == 1) return (1 - w) * g_.bulk->eval(wi, wo);
    switch (g_.surface) {
      case GrainSurface::lambert:
        return w / kPi * g_.albedo;
      case GrainSurface::mirror:
      case GrainSurface::conductor:
        return w * specular_lobe(*a, wi, wo);
      case GrainSurface::dielectric:
        break;
    }
    const double base = loss_(a->mu_i) * loss_(a->mu_o) / (kPi * loss_.mean());
    return w * (specular_lobe(*a, wi, wo) + base * g_.albedo);
  }

  /// One of the bulk's own sampler, the cosine law for Lambertian parts, and the grains' normals. A
  /// reflected direction may lie below, where the model is 0: the density counts it.
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (wo.z < 0) {
      const double open = g_.bulk_transmits ? 1 - g_.tau0 : 0;
      return u1 < open ? g_.bulk->sample(wo, u1 / open, u2, u3) : Model::sample(wo, u2, u3, u1);
    }
    const Shares p = shares(wo);
    if (u1 < p.bulk) return g_.bulk->sample(wo, u1 / p.bulk, u2, u3);
    if (u1 >= p.bulk + p.specular) return Model::sample(wo, u2, u3, u1);
    if (!g_.visible_normals)
      return mirrored(
          wo, direction_from_mu_phi(micrograin_ndf_sample(u2, g_.tau0, g_.beta), 2 * kPi * u3));
    // As many numbers as it takes; a stream keyed by the uniforms keeps the sampler a function.
    RandomStream stream(static_cast<std::uint64_t>(u2 * 0x1p53),
                        static_cast<std::uint64_t>(u3 * 0x1p53), StreamPurpose::model);
    return mirrored(wo, micrograin_visible_normal(wo, g_.tau0, g_.beta, stream));
  }

  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (wo.z < 0) {
      const double open = g_.bulk_transmits ? 1 - g_.tau0 : 0;
      return (1 - open) * Model::pdf(wi, wo) + (open > 0 ? open * g_.bulk->pdf(wi, wo) : 0);
    }
    const Shares p = shares(wo);
    double density = p.bulk > 0 ? p.bulk * g_.bulk->pdf(wi, wo) : 0;
    const double diffuse = 1 - p.bulk - p.specular;
    if (diffuse > 0) density += diffuse * Model::pdf(wi, wo);
    if (p.specular > 0) {
      // Normals point up: one half vector of two.
      Direction h = normalized(half_vector(wi, wo));
      if (h.z < 0) h = -h;
      const double cosine = dot(wo, h);
      const double d = micrograin_ndf(h.z, g_.tau0, g_.beta) / 4;
      if (g_.visible_normals) {
        const double area = micrograin_projected_area(std::max(wo.z, kGrazingLimit), g_.tau0,
                                                      g_.beta, MicrograinShadowing::smith);
        if (cosine > 0) density += p.specular * d / area;
      } else if (cosine != 0) {
        density += p.specular * d * h.z / std::abs(cosine);
      }
    }
    return density;
  }

  [[nodiscard]] double uncollided(Direction wi) const override {
    return seen_bulk(wi) * g_.bulk->uncollided(wi);
  }
  [[nodiscard]] Rgb specular(Direction wi) const override {
    if (wi.z < 0) return (1 - g_.tau0) * g_.bulk->specular(wi);
    const double mu = std::max(wi.z, kGrazingLimit);
    return (1 - micrograin_weight(mu, mu, g_.tau0, g_.beta)) * g_.bulk->specular(wi);
  }

 private:
  struct Shares {
    double bulk, specular;
  };
  /// The share of the bulk's light along w that grains leave, on its way above them; that which
  /// stays below them meets none.
  [[nodiscard]] double seen_bulk(Direction w) const {
    return 1 - micrograin_tau_plus(std::max(std::abs(w.z), kGrazingLimit), g_.tau0, g_.beta);
  }
  /// Where one direction or both lie below.
  [[nodiscard]] Rgb from_below(int lobe, Direction wi, Direction wo) const {
    if (!g_.bulk_transmits) return {};
    const bool through = (wi.z < 0) != (wo.z < 0);
    if (lobe == 1)
      return (through ? seen_bulk(wi.z < 0 ? wo : wi) : 1 - g_.tau0) * g_.bulk->eval(wi, wo);
    if (through) return {};
    return g_.tau0 / kPi * (g_.surface == GrainSurface::conductor ? g_.f0 : g_.albedo);
  }
  [[nodiscard]] Shares shares(Direction wo) const {
    const double mu = std::max(wo.z, kGrazingLimit);
    const double grains = micrograin_tau_plus(mu, g_.tau0, g_.beta);
    if (g_.surface == GrainSurface::lambert) return {1 - grains, 0};
    if (g_.surface == GrainSurface::conductor) return {1 - grains, grains};
    return {1 - grains, grains * (g_.albedo == Rgb() ? 1 : 0.5)};
  }

  [[nodiscard]] double area(double mu) const {
    return micrograin_projected_area(mu, g_.tau0, g_.beta, g_.shadowing, g_.terms);
  }

  [[nodiscard]] Rgb fresnel(double cosine) const {
    if (g_.surface == GrainSurface::dielectric) return Rgb(fresnel_reflectance(cosine, g_.ior));
    return schlick(g_.f0, schlick_weight(cosine));
  }

  [[nodiscard]] Rgb specular_lobe(const ReflectionAngles& a, Direction wi, Direction wo) const {
    const Direction h = normalized(half_vector(wi, wo));
    // G / (mu_i mu_o), which is finite at grazing
    const double shadowing = 1 / (a.mu_o * area(a.mu_i) + a.mu_i * area(a.mu_o) - a.mu_i * a.mu_o);
    return micrograin_ndf(h.z, g_.tau0, g_.beta) / 4 * shadowing * fresnel(dot(wi, h));
  }

  /// Directional albedo of the specular part from mu: over the normals, in the coordinates in which
  /// D has no peak, the integral of F G / G_1 over the visible ones. Normals of the slope t and the
  /// azimuth phi from w mirror w to above where cos phi > mu (t^2 - 1) / (2 t sin theta).
  [[nodiscard]] double specular_albedo(double mu) const {
    using Rule = boost::math::quadrature::gauss<double, 24>;
    const double lambda = grains_per_disc(g_.tau0), beta = g_.beta;
    const Direction w = direction_from_mu_phi(mu, 0);
    const double sine = std::sqrt((1 - mu) * (1 + mu)), area_w = area(mu);
    // y = sin^2 psi and 1 - y; phi in (0, pi), where half of D lies.
    const auto over_azimuths = [&](double y, double rest) {
      const double n = std::sqrt(rest), r = std::sqrt(y), t = beta * r / n;
      const double least = mu * (t - 1) * (t + 1), scale = 2 * t * sine;
      const double widest = least >= scale ? 0 : least <= -scale ? kPi : std::acos(least / scale);
      if (widest == 0) return 0.0;
      const double sum = Rule::integrate(
          [&](double phi) {
            const Direction m =
                normalized(Direction{beta * r * std::cos(phi), beta * r * std::sin(phi), n});
            const double cosine = dot(w, m), mu_o = 2 * cosine * m.z - mu;
            if (cosine <= 0 || mu_o <= 0) return 0.0;  // by rounding, at the ends
            const double g = 1 / (mu_o * area_w + mu * area(mu_o) - mu * mu_o);  // G / (mu_i mu_o)
            // D cos dm = crowding exp(-lambda y) dy dp; f mu_o dw_o = D G F / (4 mu_i) 4 cos dm
            return cosine / m.z * mu_o * g * fresnel(cosine).r;
          },
          0.0, widest);
      return crowding(g_.tau0) * std::exp(-lambda * y) * sum / kPi;
    };
    // Pieces end where all azimuths begin to matter no more, and where none is left.
    const double all = mu / (1 + sine), none = (1 + sine) / mu;
    const auto inside = [&](double t) { return t * t / (beta * beta + t * t); };
    const auto outside = [&](double t) { return beta * beta / (beta * beta + t * t); };
    const double ends[] = {0, inside(all), inside(none)};
    const double rests[] = {1, outside(all), outside(none)};
    double sum = 0;
    for (int k = 0; k < 2; ++k)
      sum += Rule::integrate(
          [&](double x) {
            const double up = std::sin(0.5 * kPi * x), down = std::cos(0.5 * kPi * x);
            const double width = ends[k + 1] - ends[k];
            return over_azimuths(ends[k] + width * up * up, rests[k + 1] + width * down * down) *
                   width * kPi * up * down;
          },
          0.0, 1.0);
    return sum;
  }

  Grains g_;
  SpecularLoss loss_;
};

ParameterInfo color(std::string name, std::string doc, std::string default_value) {
  ParameterInfo info = albedo_parameter(std::move(doc));
  info.name = std::move(name);
  info.default_value = std::move(default_value);
  return info;
}

const std::string kBulkKey = "bulk_";

MicrograinShadowing shadowing_of(const Parameters& p) {
  const std::string& shadowing = p.choice("shadowing");
  return shadowing == "ggx"     ? MicrograinShadowing::ggx
         : shadowing == "smith" ? MicrograinShadowing::smith
                                : MicrograinShadowing::series;
}

/// A part that is a function of the cosines, tau0 and beta.
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

double micrograin_projected_area(double mu, double tau0, double beta, MicrograinShadowing shadowing,
                                 int terms) {
  if (shadowing == MicrograinShadowing::ggx)
    return ggx_projected_area(mu, micrograin_equivalent_roughness(tau0, beta));
  return series_projected_area(mu, tau0, beta,
                               shadowing == MicrograinShadowing::series ? terms : -1);
}

Direction micrograin_visible_normal(Direction w, double tau0, double beta, RandomStream& stream) {
  const double lambda = grains_per_disc(tau0);
  // Stretched, the ellipsoid is a sphere; what w sees of its upper half is a half disc and half an
  // ellipse across w.
  const Direction v = normalized(Direction{beta * w.x, beta * w.y, w.z});
  const Frame<double> frame = frame_around(v);
  // The axes across v: along the horizon, and upwards.
  const double s = std::sqrt(v.x * v.x + v.y * v.y);
  const Direction side = s > 0 ? Direction{-v.y / s, v.x / s, 0} : frame.s;
  const Direction up = cross(v, side);
  for (;;) {
    const double radius = std::sqrt(stream.uniform()), phi = 2 * kPi * stream.uniform();
    const double x = radius * std::cos(phi);
    const double chord = std::sqrt(1 - x * x), share = (1 + v.z) / 2;
    const double y = chord + share * (radius * std::sin(phi) - chord);
    const double z = std::sqrt(std::max(0.0, 1 - x * x - y * y));
    const Direction n = x * side + y * up + z * v;
    const double height = std::max(0.0, n.z);
    if (stream.uniform() < std::exp(-lambda * (1 - height) * (1 + height)))
      return normalized(Direction{beta * n.x, beta * n.y, height});
  }
}

ModelInfo micrograin_model(const std::vector<ModelInfo>& models) {
  const ModelsBelow bulks(models, kBulkKey, "of the surface below");
  return {
      .name = "micrograin",
      .doc = "porous layer of opaque half ellipsoids on any surface here",
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
           choice_parameter("surface", "surface of a grain",
                            {"lambert", "dielectric", "conductor"}),
           color("albedo", "of Lambertian grains, and of what lies under a dielectric", "1"),
           color("f0", "reflectance of conductors at normal incidence (Schlick)", "1"),
           {.name = "ior",
            .unit = "1",
            .doc = "refractive index of dielectrics",
            .default_value = "1.5",
            .min = 1,
            .max = 4,
            .min_open = true},
           color("bulk_albedo", "of the surface below", "0"),
           choice_parameter(
               "shadowing",
               "ggx: Smith's of GGX with the equivalent roughness; smith: of the exact normals; "
               "series: its first terms",
               {"ggx", "smith", "series"}),
           {.name = "terms",
            .unit = "1",
            .doc = "n of the last term of shadowing=series",
            .default_value = "4",
            .min = 0,
            .max = 1000},
           choice_parameter("normals", "sampled for specular grains", {"visible", "all"}),
           choice_parameter("bulk", "closed form of the surface below", bulks.names())},
      .lobes = {{"grains", "light that meets grains", Order::one},
                {"bulk", "light that meets the surface below only", Order::one}},
      .transmits = true,
      .make =
          [bulks](const Parameters& p, const Stack*) {
            const std::string& bulk = p.choice("bulk");
            return std::make_unique<Micrograin>(
                Grains{.tau0 = p.number("tau0"),
                       .beta = p.number("beta"),
                       .ior = p.number("ior"),
                       .surface = grain_surface_from(p.choice("surface")),
                       .shadowing = shadowing_of(p),
                       .terms = static_cast<int>(p.number("terms")),
                       .visible_normals = p.choice("normals") == "visible",
                       .albedo = p.color("albedo"),
                       .f0 = p.color("f0"),
                       .bulk = bulks.named(bulk).make(bulks.values(bulk, p), nullptr),
                       .bulk_transmits = bulks.named(bulk).transmits});
          },
      .applies_to = [](const Stack& stack) -> std::optional<Parameters> {
        const GrainGeometry* g = stack.grains();
        if (!g || g->placement != GrainPlacement::micrograins ||
            g->surface == GrainSurface::dielectric)
          return std::nullopt;
        Parameters p;
        p.set("tau0", g->tau0);
        p.set("beta", g->beta);
        const bool conductor = g->surface == GrainSurface::conductor;
        // Conductors have Schlick's factor of f0, and nothing beside it.
        if (conductor && stack.layers[0].albedo != Rgb(1)) return std::nullopt;
        p.set("surface", std::string(conductor ? "conductor" : "lambert"));
        p.set("albedo", stack.layers[0].albedo);
        p.set("f0", stack.layers[0].f0);
        const Substrate& below = *stack.substrate;
        p.set("bulk_albedo", below.albedo);
        if (!below.model.empty()) {
          p.set("bulk", below.model);
          for (const auto& [key, value] : below.parameters.all()) p.set(kBulkKey + key, value);
        }
        return p;
      },
      .parts = {{"ndf", "D of the normal w_i [1/sr]",
                 of_cosines([](double mu_i, double, double tau0, double beta) {
                   return micrograin_ndf(mu_i, tau0, beta);
                 })},
                {"tau", "filling factor from w_i, of whole ellipsoids",
                 of_cosines([](double mu_i, double, double tau0, double beta) {
                   return micrograin_tau(mu_i, tau0, beta);
                 })},
                {"tau_plus", "visible filling factor from w_i",
                 of_cosines([](double mu_i, double, double tau0, double beta) {
                   return micrograin_tau_plus(mu_i, tau0, beta);
                 })},
                {"weight", "share of the paths between w_i and w_o that meet grains",
                 of_cosines(micrograin_weight)},
                {"g1", "Smith's G_1 of w_i with the projected area that `shadowing` says",
                 [](const Parameters& p, Direction wi, Direction) {
                   const double mu = std::max(std::abs(wi.z), kGrazingLimit);
                   return Rgb(mu / micrograin_projected_area(mu, p.number("tau0"), p.number("beta"),
                                                             shadowing_of(p),
                                                             static_cast<int>(p.number("terms"))));
                 }}},
      .selector = "bulk",
      .selected = [bulks](const std::string& name) { return bulks.parameters(name); },
      .selected_prefix = kBulkKey};
}

}  // namespace lamella
