#include "analytic/facets/sheen_conty_kulla.h"

#include <cmath>

#include "analytic/model/parameter_infos.h"
#include "analytic/model/reflection_angles.h"

namespace lamella {
namespace {

struct SheenFit {
  double a, b, c, d, e;
  [[nodiscard]] double operator()(double x) const {
    return a / (1 + b * std::pow(x, c)) + d * x + e;
  }
};
constexpr SheenFit kSmooth{25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
constexpr SheenFit kRough{21.5473, 3.82987, 0.19823, -1.97760, -4.32054};

// Below this cosine the fit is continued.
constexpr double kLeastCosine = 1e-3;

class Sheen final : public Model {
 public:
  Sheen(Rgb color, double roughness) : Model(1), color_(color), roughness_(roughness) {}

  [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction wi, Direction wo) const override {
    const auto angles = reflection_angles(wi, wo);
    if (!angles) return {};
    const double mu_i = angles->mu_i, mu_o = angles->mu_o;
    const Direction h = wi + wo;
    const double sine = std::sqrt((h.x * h.x + h.y * h.y) / dot(h, h));
    // G / (mu_i mu_o), finite where one of them is 0.
    const double shadowing = 1 / (mu_i * mu_o + mu_o * sheen_masking(mu_i, roughness_) +
                                  mu_i * sheen_masking(mu_o, roughness_));
    return (sheen_density(std::fmin(sine, 1), roughness_) * shadowing / 4) * color_;
  }

 private:
  Rgb color_;
  double roughness_;
};

}  // namespace

double sheen_density(double sine, double roughness) {
  const double power = 1 / roughness;
  return (2 + power) * std::pow(sine, power) / (2 * kPi);
}

double sheen_masking(double mu, double roughness) {
  const double share = (1 - roughness) * (1 - roughness);
  const auto mixed = [&](double SheenFit::*p) {
    return share * kSmooth.*p + (1 - share) * kRough.*p;
  };
  const SheenFit fit{mixed(&SheenFit::a), mixed(&SheenFit::b), mixed(&SheenFit::c),
                     mixed(&SheenFit::d), mixed(&SheenFit::e)};
  const double x = std::fmax(mu, kLeastCosine);
  return x * std::exp(x < 0.5 ? fit(x) : 2 * fit(0.5) - fit(1 - x));
}

ModelInfo sheen_conty_kulla_model() {
  return {.name = "sheen_conty_kulla",
          .doc = "sheen of cloth: facets that stand up",
          .source = "Conty and Kulla 2017, Production friendly microfacet sheen BRDF",
          .parameters = {color_parameter("color", "factor of the lobe", "1"),
                         {.name = "roughness",
                          .unit = "1",
                          .doc = "r: the smaller, the more the facets stand up",
                          .default_value = "0.5",
                          .min = 0.1,
                          .max = 1}},
          .lobes = {{"sheen", "all of it"}},
          .make =
              [](const Parameters& p, const Stack*) {
                return std::make_unique<Sheen>(p.color("color"), p.number("roughness"));
              },
          .applies_to = {}};
}

}  // namespace lamella
