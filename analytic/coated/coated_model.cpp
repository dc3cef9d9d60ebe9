#include "analytic/coated/coated_model.h"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "analytic/coated/coat_of_stack.h"
#include "analytic/facets/facet_integral.h"
#include "analytic/model/models_below.h"
#include "analytic/model/parameter_infos.h"
#include "phase/math/sampling.h"
#include "phase/surface/fresnel.h"

namespace lamella {
namespace {

// Of the directional albedo: the tables' own error hides what is below.
constexpr IntegralLimits kBaseIntegral{.tolerance = 1e-7, .evaluations = 400000, .seconds = 10};
constexpr double kCoatTolerance = 1e-7;  // of the nested rules; the error is below 1e-8

/// The mean albedo of a model over the hemisphere, cosine-weighted, at an azimuth of 45 degrees.
Rgb mean_albedo(const Model& model) {
  using Rule = boost::math::quadrature::gauss<double, 8>;
  Rgb sum;
  const auto& x = Rule::abscissa();
  const auto& w = Rule::weights();
  for (std::size_t k = 0; k < x.size(); ++k)
    for (const double sign : {-1.0, 1.0}) {
      const double mu = (1 + sign * x[k]) / 2;
      sum += (w[k] * mu) * model.albedo(direction_from_mu_phi(mu, kPi / 4));
    }
  return sum;
}

class Coated final : public Model {
 public:
  explicit Coated(const CoatedSetting& setting)
      : Model(2), s_(setting), coat_(s_.interface, s_.color, s_.layering == Layering::saunderson) {
    const bool needs_mean =
        s_.layering == Layering::darkened || s_.layering == Layering::saunderson;
    base_mean_ =
        needs_mean ? mean_albedo(*s_.base) : s_.base->albedo(direction_from_mu_phi(0.7, kPi / 4));
    const double n = coat_.index();
    if (s_.layering == Layering::saunderson)
      for (int c = 0; c < 3; ++c)
        bounces_[c] = 1 / (n * n * (1 - base_mean_[c] * coat_.internal_mean()[c]));
  }

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    if (wi.z < 0 || wo.z < 0) return {};
    wi = with_grazing_limit(wi);
    wo = with_grazing_limit(wo);
    if (lobe == 1) return base(wi, wo);
    return coat_.is_delta() ? Rgb() : coat_.interface().single(wi, wo) * s_.tint;
  }

  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    wi = with_grazing_limit(wi);
    const auto f = [&](std::span<const Direction> directions, std::span<Rgb> values) {
      for (std::size_t k = 0; k < directions.size(); ++k)
        values[k] = base(wi, with_grazing_limit(directions[k]));
    };
    const DirectionalIntegral below = integrate_projected(f, wi, std::array{1.0}, kBaseIntegral);
    AlbedoEstimate sum{below.value, below.error, below.end};
    if (coat_.is_delta()) return sum;
    const double n = coat_.index();
    const Rgb coat =
        reflected_share<double>(
            coat_.interface().facets, coat_.interface().masking, wi,
            [n](double cosine, Direction) { return fresnel_reflectance(std::fmin(cosine, 1), n); },
            kCoatTolerance) *
        s_.tint;
    sum.value += coat;
    sum.error += 1e-8 * sum.value;
    return sum;
  }

  [[nodiscard]] Rgb specular(Direction wi) const override {
    if (wi.z < 0 || !coat_.is_delta()) return {};
    return coat_.fresnel(wi.z) * s_.tint;
  }

  /// A direction below the surface, where the model is 0, where a facet reflects to there.
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (wo.z < 0) return Model::sample(wo, u1, u2, u3);
    wo = with_grazing_limit(wo);
    const double p = coat_share(wo.z);
    if (u3 >= p) return s_.base->sample(wo, u1, u2, (u3 - p) / (1 - p));
    return mirrored(wo, coat_.interface().facets.visible_normal(wo, u1, u2));
  }

  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (wo.z < 0) return Model::pdf(wi, wo);
    wo = with_grazing_limit(wo);
    const double p = coat_share(wo.z);
    double density = p < 1 ? (1 - p) * s_.base->pdf(wi, wo) : 0;
    if (p > 0) {
      const Direction h = normalized(wi + wo);
      const double cosine = dot(wo, h);
      if (cosine > 0) density += p * coat_.interface().facets.visible_density(wo, h) / (4 * cosine);
    }
    return density;
  }

 private:
  [[nodiscard]] double coat_share(double mu) const {
    if (coat_.is_delta()) return 0;
    const double coat = coat_.reflected(mu), below = (1 - coat) * base_mean_.max();
    return coat + below > 0 ? coat / (coat + below) : 0;
  }

  [[nodiscard]] Direction inside(Direction w) const {
    const double inverse = 1 / coat_.index();
    return {inverse * w.x, inverse * w.y, coat_.refracted(w.z)};
  }

  [[nodiscard]] Rgb base(Direction wi, Direction wo) const {
    if (s_.layering == Layering::saunderson)
      return bounces_ * coat_.transmitted(wi.z) * coat_.transmitted(wo.z) *
             s_.base->eval(inside(wi), inside(wo));
    return factor(wi.z, wo.z) * coat_.absorption(wi.z, wo.z) * s_.base->eval(wi, wo);
  }

  [[nodiscard]] Rgb factor(double mu_i, double mu_o) const {
    const double through = 1 - coat_.reflected(mu_o);
    switch (s_.layering) {
      case Layering::albedo_scaling:
        return Rgb(through);
      case Layering::albedo_scaling_reciprocal:
        return Rgb((1 - coat_.reflected(mu_i)) * through / (1 - coat_.reflected_mean()));
      case Layering::darkened: {
        const double n = coat_.index(), rough = 1 - (1 - coat_.fresnel_mean()) / (n * n);
        const double k = std::lerp(coat_.fresnel(mu_o), rough, s_.base_roughness);
        Rgb darkening;
        for (int c = 0; c < 3; ++c) {
          const double left = 1 - std::fmin(base_mean_[c], 1) * k;
          darkening[c] = left > 0 ? (1 - k) / left : 1;
        }
        return through * darkening;
      }
      case Layering::wolff:
        return Rgb((1 - coat_.reflected(mu_i)) * through);
      case Layering::saunderson:
        break;
    }
    return {};
  }

  CoatedSetting s_;
  Coat coat_;
  Rgb base_mean_;  // of a mean or, where only the sampler asks, of one direction
  Rgb bounces_;    // saunderson: 1 / (n^2 (1 - rho K))
};

const std::string kBaseKey = "base.";

/// The base's own parameters. A base without an albedo takes no other than 1.
Parameters base_values(const ModelsBelow& bases, const Parameters& p) {
  const ModelInfo& base = bases.named(p.choice("base"));
  if (!find(base.parameters, "albedo") && p.color(kBaseKey + "albedo") != Rgb(1))
    throw ParameterError(kBaseKey + "albedo", to_text(p.at(kBaseKey + "albedo")),
                         "1: " + base.name + " has no albedo");
  return bases.values(base.name, p);
}

Layering layering_of(const std::string& word) {
  if (word == "albedo_scaling") return Layering::albedo_scaling;
  if (word == "albedo_scaling_reciprocal") return Layering::albedo_scaling_reciprocal;
  if (word == "darkened") return Layering::darkened;
  return word == "saunderson" ? Layering::saunderson : Layering::wolff;
}

std::unique_ptr<Model> make(const ModelsBelow& bases, const Parameters& p) {
  const ModelInfo& info = bases.named(p.choice("base"));
  const Parameters below = base_values(bases, p);
  return make_coated(
      {.interface = coat_interface(facet_shape_from(p.choice("distribution")),
                                   p.number("roughness"), p.number("ior")),
       .color = p.color("color"),
       .layering = layering_of(p.choice("layering")),
       .base_roughness = info.name == "microfacet" ? std::sqrt(below.number("roughness")) : 1,
       .base = info.make(below, nullptr)});
}

}  // namespace

std::unique_ptr<Model> make_coated(const CoatedSetting& setting) {
  return std::make_unique<Coated>(setting);
}

Dielectric coat_interface(FacetShape shape, double alpha, double ior) {
  Dielectric interface;
  interface.facets = {.shape = alpha < kLeastRoughness ? FacetShape::smooth : shape,
                      .alpha_x = alpha,
                      .alpha_y = alpha};
  interface.below = ior;
  return interface;
}

ModelInfo coated_model(const std::vector<ModelInfo>& models) {
  const ModelsBelow bases(models, kBaseKey, "of the base");
  return {.name = "coated",
          .doc = "a dielectric interface over any closed form, as renderers layer them",
          .source =
              "OpenPBR Surface specification; Saunderson 1942; Wolff 1994; see "
              "analytic/coated/coated_model.h",
          .parameters =
              {number_parameter("ior", "refractive index of the coat", "1.5", 1, 4),
               number_parameter("roughness", "alpha; below 1e-4 smooth: the coat's lobe is a delta",
                                "0.1", 0, 1),
               choice_parameter("distribution", "of the facets' normals", {"ggx", "beckmann"}),
               color_parameter("color", "what two passes along the normal leave of the light", "1"),
               choice_parameter("layering", "the factor of the base's lobe",
                                {"albedo_scaling", "albedo_scaling_reciprocal", "darkened",
                                 "saunderson", "wolff"}),
               color_parameter(kBaseKey + "albedo", "of the base, where it has one", "1"),
               choice_parameter("base", "closed form below the coat", bases.names())},
          .lobes = {{"coat", "reflection from the coat's facets", Order::zero},
                    {"base", "light that reached the base", Order::scattered}},
          .reciprocal = false,
          .make = [bases](const Parameters& p, const Stack*) { return make(bases, p); },
          .applies_to = [bases](const Stack& stack) -> std::optional<Parameters> {
            const auto coat = coat_of(stack, bases.all());
            if (!coat || coat->ior < 1 || coat->ior > 4 || coat->alpha > 1) return std::nullopt;
            Parameters p;
            p.set("ior", coat->ior);
            p.set("roughness", coat->alpha);
            p.set("distribution",
                  std::string(coat->shape == FacetShape::beckmann ? "beckmann" : "ggx"));
            p.set("color", coat->color);
            p.set("base", coat->base);
            for (const auto& [key, value] : coat->parameters.all()) p.set(kBaseKey + key, value);
            return p;
          },
          .parts = {},
          .selector = "base",
          .selected = [bases](const std::string& name) { return bases.parameters(name); },
          .selected_prefix = kBaseKey,
          .alternatives = "layering"};
}

}  // namespace lamella
