#include "analytic/rough_surface/oren_nayar.h"

#include <cmath>

#include "analytic/model/formula_model.h"
#include "analytic/model/one_half_space.h"
#include "analytic/rough_surface/rough_surface_lanes.h"

namespace lamella {
namespace {

const char* const kSource =
    "Oren and Nayar 1994, Generalization of Lambert's reflectance model; Portsmouth, Kutz and "
    "Hill 2025, EON, section 2";

/// sigma^2 / (sigma^2 + offset)
double saturation(double sigma, double offset) { return sigma * sigma / (sigma * sigma + offset); }

class FullOrenNayar final : public FormulaModel<FullOrenNayarFormula> {
 public:
  FullOrenNayar(Rgb rho, double sigma)
      : FormulaModel(2, formula_of(rho, sigma), rho.is_grey(), full_oren_nayar_batch_for) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const auto s = formula_.shared(*a);
    return per_channel(
        [&](int c) { return lobe == 0 ? formula_.rho[c] * s.single : formula_.rho2[c] * s.twice; });
  }

 private:
  static FullOrenNayarFormula formula_of(Rgb rho, double sigma) {
    const double c = saturation(sigma, 0.09);
    FullOrenNayarFormula f{.rho = {},
                           .rho2 = {},
                           .c1 = 1 - 0.5 * saturation(sigma, 0.33),
                           .c2 = 0.45 * c,
                           .c3 = 0.125 * c,
                           .interaction = 0.17 * saturation(sigma, 0.13)};
    for (int k = 0; k < 3; ++k) {
      f.rho[k] = rho[k] / kPi;
      f.rho2[k] = rho[k] * rho[k] / kPi;
    }
    return f;
  }
};

/// The models of the form rho / pi (A + B s / t).
template <bool kFujii>
class Qualitative final : public FormulaModel<QualitativeFormula<kFujii>> {
  using Base = FormulaModel<QualitativeFormula<kFujii>>;

 public:
  /// `a` per channel.
  Qualitative(Rgb rho, Rgb a, double b)
      : Base(1, formula_of(rho, a, b), rho.is_grey(),
             [](Isa isa) {
               if constexpr (kFujii)
                 return fujii_batch_for(isa);
               else
                 return oren_nayar_batch_for(isa);
             }),
        rho_(rho),
        a_(a),
        b_(b) {}

  [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction wi, Direction wo) const override {
    return Base::eval(wi, wo);
  }
  /// EON eq. 5.
  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    const double g = kFujii ? fujii_integral(wi.z) : oren_nayar_integral(wi.z);
    return exact_albedo(rho_ * (a_ + Rgb(b_ / kPi * g)));
  }

 private:
  static QualitativeFormula<kFujii> formula_of(Rgb rho, Rgb a, double b) {
    return {.rho = {rho.r / kPi, rho.g / kPi, rho.b / kPi}, .a = {a.r, a.g, a.b}, .b = b};
  }

  Rgb rho_, a_;
  double b_;
};

template <class Make>
ModelInfo info(std::string name, std::string doc, std::string source, std::vector<LobeInfo> lobes,
               const Make& make) {
  return {.name = std::move(name),
          .doc = std::move(doc),
          .source = std::move(source),
          .parameters = {albedo_parameter("albedo of the facets"),
                         {.name = "sigma",
                          .unit = "rad",
                          .doc = "standard deviation of the facets' slope angle",
                          .default_value = "0.5",
                          .min = 0,
                          .max = kPi / 2}},
          .lobes = std::move(lobes),
          .make = [make](const Parameters& p, const Stack*) -> std::unique_ptr<Model> {
            return make(p.color("albedo"), p.number("sigma"));
          },
          .applies_to = {}};
}

ModelInfo qualitative_info(std::string name, std::string doc, double offset) {
  return info(std::move(name), std::move(doc), kSource, {{"diffuse", "all of it"}},
              [offset](Rgb rho, double sigma) {
                return std::make_unique<Qualitative<false>>(
                    rho, Rgb(1 - 0.5 * saturation(sigma, offset)), 0.45 * saturation(sigma, 0.09));
              });
}

}  // namespace

double oren_nayar_integral(double mu) {
  const double s = std::sqrt((1 - mu) * (1 + mu));
  const double theta = std::atan2(s, mu);
  return s * (theta - s * mu) + 2.0 / 3 * s * mu * (1 + s + s * s) / (1 + s);
}

double fujii_integral(double mu) {
  return oren_nayar_integral(mu) - 2.0 / 3 * std::sqrt((1 - mu) * (1 + mu));
}

ModelInfo oren_nayar_full_model() {
  return info("oren_nayar_full", "rough V-cavities with single and double scattering", kSource,
              {{"single", "one event", Order::one}, {"double", "two events", Order::two}},
              [](Rgb rho, double sigma) { return std::make_unique<FullOrenNayar>(rho, sigma); });
}

ModelInfo oren_nayar_model() {
  return qualitative_info("oren_nayar", "the qualitative Oren-Nayar model", 0.33);
}

ModelInfo oren_nayar_footnote_model() {
  return qualitative_info("oren_nayar_footnote",
                          "the qualitative Oren-Nayar model with its footnote's 0.57", 0.57);
}

ModelInfo fujii_qualitative_model() {
  return info("fujii_qualitative", "Fujii's qualitative fit to the full Oren-Nayar model",
              "Fujii 2013, A tiny improvement of Oren-Nayar reflectance model",
              {{"diffuse", "all of it"}}, [](Rgb rho, double sigma) {
                const Rgb a =
                    Rgb(1 - 0.5 * saturation(sigma, 0.33)) + 0.17 * saturation(sigma, 0.13) * rho;
                return std::make_unique<Qualitative<true>>(rho, a, 0.45 * saturation(sigma, 0.09));
              });
}

}  // namespace lamella
