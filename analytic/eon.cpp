#include "analytic/eon.h"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "analytic/half_space.h"
#include "analytic/oren_nayar.h"

namespace lamella {
namespace {

double fon_a(double roughness) { return 1 / (1 + (0.5 - 2 / (3 * kPi)) * roughness); }

/// The frame around the normal in which w has azimuth 0.
Frame<double> frame_of(Direction w) {
  const double s = std::sqrt(w.x * w.x + w.y * w.y);
  const Direction x = s > 0 ? Direction{w.x / s, w.y / s, 0} : Direction{1, 0, 0};
  return {x, {-x.y, x.x, 0}, {0, 0, 1}};
}

/// What FON loses, 1 - E = A r loss(mu), with loss(mu) = 1/2 - 2 / (3 pi) - G_F / pi.
constexpr double kGrazingLoss = 0.5 - 2 / (3 * kPi);
/// Its cosine-weighted mean: 1 - <E> = A r kMeanLoss.
constexpr double kMeanLoss = kGrazingLoss - kFujiiMean;

double fon_loss(double mu) { return std::max(0.0, kGrazingLoss - fujii_integral(mu) / kPi); }

/// G_F / pi by eq. 14.
double fujii_integral_fit(double mu) {
  const double x = 1 - mu;
  return x * (0.0571085289 + x * (0.491881867 + x * (-0.332181442 + x * 0.0714429953)));
}

double fon_loss_fit(double mu) { return std::max(0.0, kGrazingLoss - fujii_integral_fit(mu)); }

/// Cosine-weighted mean of fon_loss_fit: a polynomial above the cosine at which the clamp ends.
double mean_loss_fit() {
  double low = 0, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (fon_loss_fit(middle) > 0 ? high : low) = middle;
  }
  const auto f = [](double mu) { return 2 * mu * (kGrazingLoss - fujii_integral_fit(mu)); };
  return boost::math::quadrature::gauss<double, 7>::integrate(f, high, 1.0);
}

enum class Variant { fon, exact, fit };

class Eon final : public Model {
 public:
  Eon(Rgb rho, double roughness, Variant variant)
      : Model(variant == Variant::fon ? 1 : 2),
        rho_(rho),
        roughness_(roughness),
        a_(fon_a(roughness)),
        variant_(variant) {
    if (variant == Variant::fon) return;
    const double average = fon_average_albedo(roughness);
    for (int c = 0; c < 3; ++c)
      lobe_[c] =
          rho[c] * rho[c] * average / (1 - rho[c] * (1 - average)) * a_ * roughness / kMeanLoss;
    static const double mean_fit = mean_loss_fit();
    mean_loss_ = variant == Variant::fit ? mean_fit : kMeanLoss;
  }

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    if (lobe == 0) return a_ / kPi * (1 + roughness_ * fujii_term(*a)) * rho_;
    return loss(a->mu_i) * loss(a->mu_o) / kPi * lobe_;
  }

  [[nodiscard]] Rgb albedo(Direction wi) const override {
    if (wi.z < 0) return Rgb();
    const Rgb single = fon_albedo(wi.z, roughness_) * rho_;
    return variant_ == Variant::fon ? single : single + loss(wi.z) * mean_loss_ * lobe_;
  }

  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (variant_ == Variant::fon || wo.z < 0) return Model::sample(wo, u1, u2, u3);
    return frame_of(wo).to_world(EonSampler(wo.z, roughness_).sample(u1, u2, u3));
  }

  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (variant_ == Variant::fon || wo.z < 0) return Model::pdf(wi, wo);
    return wi.z < 0 ? 0 : EonSampler(wo.z, roughness_).pdf(frame_of(wo).to_local(wi));
  }

 private:
  [[nodiscard]] double loss(double mu) const {
    return variant_ == Variant::fit ? fon_loss_fit(mu) : fon_loss(mu);
  }

  Rgb rho_;
  double roughness_, a_;
  Variant variant_;
  Rgb lobe_;  // pi f_ms per unit of loss(mu_i) loss(mu_o)
  double mean_loss_ = 0;
};

ModelInfo info(std::string name, std::string doc, Variant variant) {
  const bool fon = variant == Variant::fon;
  std::vector<LobeInfo> lobes{{"ss", "Fujii's single scattering", Order::all}};
  if (!fon) lobes.push_back({"ms", "the energy that single scattering loses", Order::all});
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
                          .max = 1}},
          .lobes = std::move(lobes),
          .make =
              [variant](const Parameters& p, const Stack*) {
                return std::make_unique<Eon>(p.color("albedo"), p.number("roughness"), variant);
              },
          .applies_to = {}};
}

}  // namespace

double fon_albedo(double mu, double roughness) {
  return fon_a(roughness) * (1 + roughness / kPi * fujii_integral(mu));
}

double fon_albedo_fit(double mu, double roughness) {
  return fon_a(roughness) * (1 + roughness * fujii_integral_fit(mu));
}

double fon_average_albedo(double roughness) {
  return fon_a(roughness) * (1 + roughness * kFujiiMean);
}

EonSampler::EonSampler(double mu, double r) {
  const double m = std::min(mu, 1.0);
  m_ = {1 + r * (0.303392 + (-0.518982 + 0.111709 * m) * m + (-0.276266 + 0.335918 * m) * r),
        r * (-1.16407 + 1.15859 * m + (0.150815 - 0.150105 * m) * r) / (m * m * m - 1.43545),
        1 + (0.20013 + (-0.506373 + 0.261777 * m) * m) * r,
        r * (0.540852 + (-1.01625 + 0.475392 * m) * m) / (-1.0743 + m * (0.0725628 + m))};
  uniform_ = std::pow(r, 0.1) * (0.162925 + m * (-0.372058 + (0.538233 - 0.290822 * m) * m));
  area_ = 0.5 * (1 + 1 / std::sqrt(1 + m_[3] * m_[3]));
}

Direction EonSampler::sample(double u1, double u2, double u3) const {
  const double phi = 2 * kPi * u3;
  if (u1 < uniform_) {
    const double s = std::sqrt((1 - u2) * (1 + u2));
    return {s * std::cos(phi), s * std::sin(phi), u2};
  }
  // The part of the unit disc over which d x + z > 0: half the disc and, on the side where d x < 0,
  // half an ellipse. Each chord of the disc is squeezed onto its part.
  const auto [a, b, c, d] = m_;
  const double radius = std::sqrt(u2);
  const double y = radius * std::sin(phi);
  const double chord = std::sqrt(std::max(0.0, 1 - y * y));
  const double x = std::copysign(1.0, d) * (chord + area_ * (radius * std::cos(phi) - chord));
  const double z = std::sqrt(std::max(0.0, 1 - x * x - y * y));
  const Direction w = normalized(Direction{a * x + b * z, c * y, d * x + z});
  return {w.x, w.y, std::max(w.z, 0.0)};
}

double EonSampler::clipped_pdf(Direction wi) const {
  const auto [a, b, c, d] = m_;
  const double e = a - b * d, determinant = c * e;
  // The adjugate of M times w_i
  const Direction h{c * (wi.x - b * wi.z), e * wi.y, c * (a * wi.z - d * wi.x)};
  const double l2 = dot(h, h);
  return std::max(0.0, h.z) * determinant * determinant / (l2 * l2 * kPi * area_);
}

double EonSampler::pdf(Direction wi) const {
  return uniform_ / (2 * kPi) + (1 - uniform_) * clipped_pdf(wi);
}

ModelInfo fon_model() { return info("fon", "Fujii's Oren-Nayar model", Variant::fon); }

ModelInfo eon_model() { return info("eon", "energy-preserving Oren-Nayar model", Variant::exact); }

ModelInfo eon_approx_model() {
  return info("eon_approx", "energy-preserving Oren-Nayar model with a fitted albedo",
              Variant::fit);
}

}  // namespace lamella
