#include "analytic/oren_nayar.h"

#include <cmath>

#include "analytic/half_space.h"

namespace lamella {
namespace {

const char* const kSource =
    "Oren and Nayar 1994, Generalization of Lambert's reflectance model; Portsmouth, Kutz and "
    "Hill 2025, EON, section 2";

/// sigma^2 / (sigma^2 + offset)
double saturation(double sigma, double offset) { return sigma * sigma / (sigma * sigma + offset); }

class FullOrenNayar final : public Model {
 public:
  FullOrenNayar(Rgb rho, double sigma) : Model(2), rho_(rho), sigma_(sigma) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    return lobe == 0 ? single(*a) / kPi * rho_ : twice(*a) / kPi * (rho_ * rho_);
  }

 private:
  [[nodiscard]] double single(const ReflectionAngles& a) const {
    // The angle nearer to grazing is alpha, whose sine is the larger one.
    const bool i_grazes = a.mu_i < a.mu_o;
    const double mu_b = i_grazes ? a.mu_o : a.mu_i;
    const double sin_a = i_grazes ? a.sin_i : a.sin_o, sin_b = i_grazes ? a.sin_o : a.sin_i;
    const double alpha = std::atan2(sin_a, i_grazes ? a.mu_i : a.mu_o);
    const double beta = std::atan2(sin_b, mu_b);
    const double x = a.cos_phi, b = 2 * beta / kPi, c = saturation(sigma_, 0.09);
    const double c1 = 1 - 0.5 * saturation(sigma_, 0.33);
    const double c2 = 0.45 * c * (sin_a - (x < 0 ? b * b * b : 0));
    const double ab = 2 * alpha / kPi * b;
    const double c3 = 0.125 * c * ab * ab;
    const double tan_mean = (sin_a + sin_b) / (a.mu_i + a.mu_o);  // tan((alpha + beta) / 2)
    return c1 + x * c2 * (sin_b / mu_b) + (1 - std::abs(x)) * c3 * tan_mean;
  }
  [[nodiscard]] double twice(const ReflectionAngles& a) const {
    const double mu = std::max(a.mu_i, a.mu_o);
    const double b = 2 / kPi * std::atan2(std::min(a.sin_i, a.sin_o), mu);
    return 0.17 * saturation(sigma_, 0.13) * (1 - a.cos_phi * b * b);
  }

  Rgb rho_;
  double sigma_;
};

/// The models of the form rho / pi (A + B s / t).
class Qualitative final : public Model {
 public:
  /// `a` per channel; fujii: t is 1 where s is negative.
  Qualitative(Rgb rho, Rgb a, double b, bool fujii)
      : Model(1), rho_(rho), a_(a), b_(b), fujii_(fujii) {}

  [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const double term = fujii_ ? fujii_term(*a) : oren_nayar_term(*a);
    return 1 / kPi * rho_ * (a_ + Rgb(b_ * term));
  }
  /// EON eq. 5.
  [[nodiscard]] Rgb albedo(Direction wi) const override {
    if (wi.z < 0) return Rgb();
    const double g = fujii_ ? fujii_integral(wi.z) : oren_nayar_integral(wi.z);
    return rho_ * (a_ + Rgb(b_ / kPi * g));
  }

 private:
  Rgb rho_, a_;
  double b_;
  bool fujii_;
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
                return std::make_unique<Qualitative>(rho, Rgb(1 - 0.5 * saturation(sigma, offset)),
                                                     0.45 * saturation(sigma, 0.09), false);
              });
}

}  // namespace

double oren_nayar_term(const ReflectionAngles& a) {
  return std::max(0.0, a.sines_cos) / std::max(a.mu_i, a.mu_o);
}

double fujii_term(const ReflectionAngles& a) {
  return a.sines_cos > 0 ? oren_nayar_term(a) : a.sines_cos;
}

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
                return std::make_unique<Qualitative>(rho, a, 0.45 * saturation(sigma, 0.09), true);
              });
}

}  // namespace lamella
