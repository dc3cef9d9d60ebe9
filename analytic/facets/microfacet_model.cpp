#include "analytic/facets/microfacet_model.h"

#include <cmath>

#include "analytic/facets/cosine_table.h"
#include "analytic/facets/facet_integral.h"
#include "analytic/facets/facet_lanes.h"
#include "analytic/model/parameter_infos.h"
#include "phase/interface/dielectric.h"
#include "phase/math/sampling.h"
#include "phase/surface/conductor.h"
#include "phase/surface/fresnel.h"

namespace lamella {
namespace {

enum class Compensation { none, kulla_conty, turquin };

constexpr double kAlbedoTolerance = 1e-7;  // of the nested rules; the error is below 1e-8

// An index nearer to 1 has no facets that could be resolved.
constexpr double kLeastStep = 0.9e-4;

// Of tables: losses go like mu log mu near 0, those of dielectrics like (1 - mu) log(1 - mu)
// near 1.
constexpr int kTerms = 9;
constexpr double kNear0 = 1e-6, kNear1 = 0.05, kNear1Dielectric = 1e-4;

// Below this mean loss nothing is made up for: rounding.
constexpr double kLeastLoss = 1e-11;

Direction lifted(Direction w) { return {w.x, w.y, std::abs(w.z)}; }

/// What single scattering loses of light from w, as what the rest leaves where that is no
/// difference of nearly equal numbers.
double loss_of(const Facets& facets, Masking masking, double ratio, Direction w) {
  const bool white = ratio == 0;
  double left = 1 - reflected_share<double>(
                        facets, masking, w,
                        [&](double cosine, Direction) {
                          return white ? 1 : fresnel_reflectance(std::fmin(cosine, 1), ratio);
                        },
                        1e-7, white ? 0 : critical_cosine(ratio));
  if (!white)
    left -= refracted_share(
        facets, masking, ratio, w, [](double) { return 1.0; }, 1e-6);
  return left > 1e-3 ? left : lost_share(facets, masking, ratio, w, 1e-5);
}

/// The same from a cosine on one side, tabulated, and its mean.
class FacetLoss {
 public:
  FacetLoss() = default;
  FacetLoss(const Facets& facets, Masking masking, double ratio)
      : table_(
            [&](double mu) {
              return loss_of(facets, masking, ratio,
                             direction_from_mu_phi(std::fmax(mu, kGrazingLimit), 0));
            },
            kTerms, kNear0, ratio > 0 ? kNear1Dielectric : kNear1) {}
  [[nodiscard]] double operator()(double mu) const { return nonnegative(table_(std::abs(mu))); }
  [[nodiscard]] double mean() const { return table_.mean(); }

 private:
  CosineTable table_;
};

/// Single scattering of all pairs on lanes, and the pairs that ask for double by `single`.
template <class Single>
void evaluate_facets(const FacetFormula& formula, int channels,
                     std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa,
                     const Single& single) {
  static_assert(sizeof(DirectionPair) == 6 * sizeof(double) && sizeof(Rgb) == 3 * sizeof(double));
  facet_batch_for(isa)(&formula, channels, reinterpret_cast<const double*>(pairs.data()),
                       reinterpret_cast<double*>(values.data()), pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (std::fmin(std::abs(pairs[k].wi.z), std::abs(pairs[k].wo.z)) < FacetFormula::kLeastCosine)
      values[k] = single(pairs[k].wi, pairs[k].wo);
}

FacetFormula formula_of(const Facets& facets, Masking masking) {
  return {.ggx = facets.shape == FacetShape::ggx,
          .masking = masking,
          .alpha_x = facets.alpha_x,
          .alpha_y = facets.alpha_y};
}

class ConductorFacets final : public Model {
 public:
  ConductorFacets(const Conductor::Setting& setting, Compensation compensation)
      : Model(2),
        law_(setting),
        compensation_(compensation),
        formula_(formula_of(setting.facets, setting.masking)) {
    formula_.white = setting.white;
    for (int c = 0; c < 3; ++c) {
      formula_.eta[c] = setting.eta[c];
      formula_.k[c] = setting.k[c];
    }
    if (compensation == Compensation::none) return;
    loss_ = FacetLoss(setting.facets, setting.masking, 0);
    const double lost = loss_.mean();
    if (compensation == Compensation::turquin) {
      scale_ = law_.reflectance(1);
    } else if (lost > kLeastLoss) {
      const double edges[] = {0, 1};
      const Rgb mean = integrate_adaptively<Rgb>(
          [&](double mu) { return 2 * mu * law_.reflectance(mu); }, edges, 1e-10);
      for (int c = 0; c < 3; ++c)
        scale_[c] = mean[c] * mean[c] * (1 - lost) / ((1 - mean[c] * lost) * kPi * lost);
    }
  }

  using Model::eval;
  /// On lanes where nothing is compensated for: that takes tables.
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa) const override {
    if (isa == Isa::scalar || compensation_ != Compensation::none)
      return Model::eval(pairs, values, isa);
    evaluate_facets(formula_, formula_.white ? 1 : 3, pairs, values, isa,
                    [this](Direction wi, Direction wo) { return eval_lobe(0, wi, wo); });
  }

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    if (wi.z < 0 || wo.z < 0) return {};
    if (lobe == 0) return law_.single(wi, wo);
    switch (compensation_) {
      case Compensation::none:
        return {};
      case Compensation::kulla_conty:
        return (loss_(wi.z) * loss_(wo.z)) * scale_;
      case Compensation::turquin:
        break;
    }
    return gained(wo.z) * (scale_ * law_.single(wi, wo));
  }

  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    wi = with_grazing_limit(wi);
    const Conductor::Setting& s = law_.setting();
    Rgb value = reflected_share<Rgb>(
        s.facets, s.masking, wi,
        [&](double cosine, Direction wo) {
          const Rgb f = law_.reflectance(std::fmin(cosine, 1));
          return compensation_ == Compensation::turquin ? f + gained(wo.z) * (scale_ * f) : f;
        },
        kAlbedoTolerance);
    if (compensation_ == Compensation::kulla_conty)
      value += (kPi * loss_.mean() * loss_(wi.z)) * scale_;
    return {value, (0.1 * kAlbedoTolerance) * value, {}};
  }

  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (wo.z < 0 || u3 < diffuse_share(wo)) return Model::sample(wo, u1, u2, u3);
    return mirrored(with_grazing_limit(wo),
                    law_.setting().facets.visible_normal(with_grazing_limit(wo), u1, u2));
  }
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (wo.z < 0) return Model::pdf(wi, wo);
    const double p = diffuse_share(wo);
    return p * (p > 0 ? Model::pdf(wi, wo) : 0) + (1 - p) * law_.single_density(wo, wi);
  }

 private:
  [[nodiscard]] double gained(double mu) const {
    const double lost = loss_(mu);
    return lost / (1 - lost);
  }
  [[nodiscard]] double diffuse_share(Direction wo) const {
    return compensation_ == Compensation::kulla_conty ? loss_(wo.z) : 0;
  }

  Conductor law_;
  Compensation compensation_;
  FacetFormula formula_;
  FacetLoss loss_;
  Rgb scale_;  // kulla_conty: what the losses' product is multiplied by; turquin: F_0
};

class DielectricFacets final : public Model {
 public:
  DielectricFacets(const Dielectric& law, Compensation compensation)
      : Model(2),
        law_(law),
        compensation_(compensation),
        formula_(formula_of(law.facets, law.masking)) {
    formula_.ratio = law.below / law.above;
    if (compensation == Compensation::none) return;
    const double n = law.below / law.above;
    for (const bool below : {false, true})
      sides_[below].loss = FacetLoss(law.facets, law.masking, below ? 1 / n : n);
    for (const bool below : {false, true}) {
      Side& side = sides_[below];
      const double lost = side.loss.mean(), other = sides_[!below].loss.mean();
      if (!(lost > kLeastLoss && other > kLeastLoss)) continue;
      const double edges[] = {0, std::sqrt(nonnegative(1 - 1 / (n * n))), 1};
      const double mean = integrate_adaptively<double>(
          [&](double mu) { return 2 * mu * fresnel_reflectance(mu, below ? 1 / n : n); }, edges,
          1e-10);
      side.stays = 1 - std::fmin(1, other / lost) * (1 - mean);
      side.scale = 1 / (kPi * lost);
    }
  }

  using Model::eval;
  /// On lanes where nothing is compensated for: that takes tables.
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa) const override {
    if (isa == Isa::scalar || compensation_ != Compensation::none)
      return Model::eval(pairs, values, isa);
    evaluate_facets(formula_, 1, pairs, values, isa,
                    [this](Direction wi, Direction wo) { return eval_lobe(0, wi, wo); });
  }

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    if (lobe == 0) return Rgb(law_.single(wi, wo));
    switch (compensation_) {
      case Compensation::none:
        return {};
      case Compensation::kulla_conty: {
        const Side &from = side_of(wi), &to = side_of(wo);
        return Rgb(share(wi, wo) * from.loss(wi.z) * to.loss(wo.z) * to.scale);
      }
      case Compensation::turquin:
        break;
    }
    return Rgb(gained(wo) * law_.single(wi, wo));
  }

  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    wi = with_grazing_limit(wi);
    const double ratio = law_.ratio(wi);
    const bool scaled = compensation_ == Compensation::turquin;
    const double up = wi.z < 0 ? -1 : 1;
    const Direction w = lifted(wi);
    double value = reflected_share<double>(
                       law_.facets, law_.masking, w,
                       [&](double cosine, Direction wo) {
                         return fresnel_reflectance(std::fmin(cosine, 1), ratio) *
                                (scaled ? 1 + gained({0, 0, up * wo.z}) : 1);
                       },
                       kAlbedoTolerance, critical_cosine(ratio)) +
                   refracted_share(
                       law_.facets, law_.masking, ratio, w,
                       [&](double mu) {
                         return scaled ? 1 + gained({0, 0, -up * mu}) : 1;
                       },
                       kAlbedoTolerance);
    if (compensation_ == Compensation::kulla_conty && side_of(wi).scale > 0)
      value += side_of(wi).loss(wi.z);
    return {Rgb(value), Rgb(0.1 * kAlbedoTolerance * value), {}};
  }

  /// Nothing where the facet sends light to the wrong side.
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    wo = with_grazing_limit(wo);
    const double p = diffuse_share(wo);
    if (u3 < p) {
      const bool stays = u3 < p * side_of(wo).stays;
      return Model::sample(stays ? wo : -wo, u1, u2, u3);
    }
    const double turn = wo.z < 0 ? -1 : 1, n = law_.ratio(wo);
    const Direction w = turn * wo;
    const Direction m = law_.facets.visible_normal(w, u1, u2);
    const double cosine = dot(w, m);
    const Refraction<double> r = refraction(std::fmin(cosine, 1), n);
    const bool refracts = r.cosine > 0 && (u3 - p) >= r.reflectance * (1 - p);
    const Direction wi = refracts ? refracted_ray(w, m, cosine, r.cosine, n) : mirrored(w, m);
    if (!(cosine > 0) || !(refracts ? wi.z < 0 : wi.z > 0)) return std::nullopt;
    return turn * wi;
  }
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    wo = with_grazing_limit(wo);
    const double p = diffuse_share(wo);
    const double single = law_.single_density(wo, wi);
    if (!(p > 0)) return single;
    return (1 - p) * single + p * share(wo, wi) * std::abs(wi.z) / kPi;
  }

 private:
  struct Side {
    FacetLoss loss;
    double stays = 1;  // of what is made up for, the share on the same side
    double scale = 0;  // 1 / (pi L)
  };
  [[nodiscard]] const Side& side_of(Direction w) const { return sides_[w.z < 0]; }
  // Of what is lost from w_i, the share that w_o's side has.
  [[nodiscard]] double share(Direction wi, Direction wo) const {
    const double stays = side_of(wi).stays;
    return (wi.z < 0) == (wo.z < 0) ? stays : 1 - stays;
  }
  [[nodiscard]] double gained(Direction w) const {
    const double lost = side_of(w).loss(w.z);
    return lost / (1 - lost);
  }
  [[nodiscard]] double diffuse_share(Direction wo) const {
    const Side& side = side_of(wo);
    return compensation_ == Compensation::kulla_conty && side.scale > 0 ? side.loss(wo.z) : 0;
  }

  Dielectric law_;
  Compensation compensation_;
  FacetFormula formula_;
  Side sides_[2];  // above, below
};

std::unique_ptr<Model> make(const Parameters& p) {
  const std::string& word = p.choice("compensation");
  const Compensation compensation = word == "none"          ? Compensation::none
                                    : word == "kulla_conty" ? Compensation::kulla_conty
                                                            : Compensation::turquin;
  const double along_y = p.number("roughness_y");
  const Facets facets{.shape = facet_shape_from(p.choice("distribution")),
                      .alpha_x = p.number("roughness"),
                      .alpha_y = along_y > 0 ? along_y : p.number("roughness")};
  if (compensation != Compensation::none && facets.alpha_x != facets.alpha_y)
    throw ParameterError("compensation", to_text(ParameterValue(word)),
                         "none where the roughness along y is another");
  if (facets.alpha_y < kLeastRoughness)
    throw ParameterError("roughness_y", to_text(along_y), "0 (as along x), or 1e-4 to 1");
  const Masking masking = masking_from(p.choice("masking"));
  const std::string& material = p.choice("material");
  if (material == "dielectric" && std::abs(p.number("ior") - 1) < kLeastStep)
    throw ParameterError("ior", to_text(p.number("ior")), "what differs from 1 by 1e-4 or more");
  if (material == "dielectric")
    return std::make_unique<DielectricFacets>(
        Dielectric{.facets = facets, .masking = masking, .below = p.number("ior")}, compensation);
  return std::make_unique<ConductorFacets>(Conductor::Setting{.facets = facets,
                                                              .masking = masking,
                                                              .eta = p.color("eta"),
                                                              .k = p.color("k"),
                                                              .white = material == "white"},
                                           compensation);
}

}  // namespace

namespace {

// A height field of white mirrors; coloured ones have Schlick's factor, which this model has not.
std::optional<Parameters> of_white_heights(const Stack& stack, const GrainGeometry& field) {
  if (!field.is_height_field() || field.surface != GrainSurface::mirror ||
      stack.layers[0].albedo != Rgb(1) || stack.layers[0].f0 != Rgb(1) ||
      field.alpha < kLeastRoughness || field.alpha > 1)
    return std::nullopt;
  Parameters p;
  p.set("material", std::string("white"));
  p.set("distribution", std::string("beckmann"));
  p.set("roughness", field.alpha);
  return p;
}

}  // namespace

ModelInfo microfacet_model() {
  return {
      .name = "microfacet",
      .doc = "facets of a rough conductor or dielectric",
      .source =
          "Walter et al. 2007, Microfacet models for refraction; Kulla and Conty 2017; Turquin "
          "2019",
      .parameters =
          {choice_parameter("material", "white: a conductor that reflects everything",
                            {"conductor", "dielectric", "white"}),
           choice_parameter("distribution", "of the facets' normals", {"ggx", "beckmann"}),
           number_parameter("roughness", "alpha", "0.3", kLeastRoughness, 1),
           number_parameter("roughness_y", "alpha along y; 0: as along x", "0", 0, 1),
           number_parameter("ior", "of dielectrics: refractive index below over above", "1.5", 0.25,
                            4),
           color_parameter("eta", "of conductors: real part of the index", "0.20,0.92,1.10", 20),
           color_parameter("k", "of conductors: imaginary part of the index", "3.91,2.45,2.14", 20),
           choice_parameter(
               "masking",
               "beta: a Smith surface's; separable: Walter's; correlated: 1 / (1 + L_i + L_o)",
               {"beta", "separable", "correlated"}),
           choice_parameter("compensation", "for what single scattering loses",
                            {"none", "kulla_conty", "turquin"})},
      .lobes = {{"single", "one facet", Order::all},
                {"multiple", "what compensates for the others", Order::all}},
      .transmits = true,
      .make = [](const Parameters& p, const Stack*) { return make(p); },
      .applies_to = [](const Stack& stack) -> std::optional<Parameters> {
        if (const GrainGeometry* field = stack.grains()) return of_white_heights(stack, *field);
        if (!stack.layers.empty() || !stack.substrate || stack.substrate->model != kConductor)
          return std::nullopt;
        const Parameters& given = stack.substrate->parameters;
        const double* alpha =
            given.has("roughness") ? std::get_if<double>(&given.at("roughness")) : nullptr;
        if (!alpha || *alpha < kLeastRoughness || *alpha > 1) return std::nullopt;
        Parameters p;
        p.set("material", std::string(given.choice("fresnel") == "one" ? "white" : "conductor"));
        for (const char* key : {"eta", "k", "distribution", "masking"}) p.set(key, given.at(key));
        p.set("roughness", *alpha);
        return p;
      },
      .parts = {},
      .selector = {},
      .selected = {},
      .selected_prefix = {},
      .alternatives = "compensation"};
}

}  // namespace lamella
