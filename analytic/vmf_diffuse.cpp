#include "analytic/vmf_diffuse.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

#include "analytic/half_space.h"
#include "analytic/reflection_angles.h"
#include "analytic/vmf_diffuse_sampler.h"
#include "analytic/vmf_sigma_fit.h"

namespace lamella {
namespace {

/// The coefficients C_kmj of one roughness.
struct Coefficients {
  std::array<double, 4> c10;
  std::array<double, 3> c11;
  std::array<double, 2> c12;
  std::array<double, 5> c20, c30;
  std::array<double, 3> c21, c31;

  explicit Coefficients(double r) {
    const double r2 = r * r, r25 = r2 * std::sqrt(r), r3 = r2 * r, r4 = r2 * r2;
    c10 = {1 + (0.84 * r4 - 0.1 * r) / (9 * r3 + 1),
           (-9.47 * r3 + 20.4 * r2 + 0.0173 * r) / (7.46 * r + 1),
           (2.37 * r2 - 0.927 * r) / (r2 + 1.24),
           (-1.54 * r2 - 0.11 * r) / (7.1 * r2 - 1.05 * r + 1)};
    c11 = {(0.54 * r - 0.182 * r3) / (1.32 * r2 + 1),
           (-0.375 * r3 + 0.62 * r2 - 0.097 * r) / (0.4 * r3 + 1), -0.681 * r2 + 0.862 * r + 0.283};
    c12 = {(5.1 * r2 + 2.25 * r) / (32.4 * r2 + 9.8 * r + 1),
           (6 * r3 - 4.32 * r) / (287 * r3 + 9.7 * r + 1)};
    c20 = {(0.226 * r2 + 0.00056 * r) / (7.07 * r2 + 1),
           (-12.04 * r3 + 4.57 * r2 - 0.268 * r) / (36.7 * r3 + 1),
           (-0.97 * r3 + 2.52 * r2 + 0.418 * r) / (10 * r2 + 1),
           (2.65 * r3 - 2.25 * r2 + 0.068 * r) / (21.4 * r3 + 1),
           (0.05 * r - 4.22 * r3) / (43.1 * r3 + 17.6 * r2 + 1)};
    c21 = {(-0.027 * r3 - 0.049 * r) / (3.36 * r2 + 1),
           (-8.332 * r25 + 6.073 * r3 + 2.77 * r2) / (50 * r4 + 1),
           (-0.295 * r3 - 0.431 * r2) / (23.9 * r3 + 1)};
    c30 = {(0.262 * r4 - 0.083 * r3) / (38.6 * r4 - 1.9 * r2 + 1),
           (4.95 * r25 - 2.44 * r3 - 0.627 * r2) / (31.5 * r4 + 1),
           (0.31 * r25 + 1.4 * r3 + 0.33 * r2) / (20 * r3 + 1),
           (1.77 * r25 - 4.06 * r3 - 0.74 * r2) / (215 * r4 * r + 1),
           -1.026 * r3 / (13.2 * r3 + 5.81 * r2 + 1)};
    c31 = {(0.028 * r2 - 0.0132 * r3) / (-3.315 * r4 + 7.46 * r2 + 1),
           (0.162 * r25 + 0.302 * r3 - 0.134 * r2) / (57.5 * r4 * std::sqrt(r) + 1),
           (0.5 * r25 - 0.207 * r3 - 0.119 * r2) / (18.7 * r3 + 1)};
  }
};

double sines(double ui, double uo) { return std::sqrt((1 - ui) * (1 + ui) * (1 - uo) * (1 + uo)); }

class Modes {
 public:
  explicit Modes(double roughness) : alpha_(vmf_alpha(roughness)), c_(roughness) {}

  /// f_1^(0), f_1^(1), f_1^(2), which share the projected areas.
  [[nodiscard]] std::array<double, 3> first_order(double ui, double uo) const {
    const double si = vmf_sigma_fit(ui, alpha_), so = vmf_sigma_fit(uo, alpha_);
    const double denominator = kPi * (ui * vmf_sigma_fit(-uo, alpha_) + uo * si);
    const double product = ui * uo;
    const auto& a = c_.c10;
    const auto& b = c_.c11;
    const auto& d = c_.c12;
    return {si * so / denominator *
                (a[0] + a[1] * product + a[2] * product * product + a[3] * (ui * ui + uo * uo)),
            std::pow(si * so, b[2]) / denominator * sines(ui, uo) * (b[0] + b[1] * product),
            (1 - ui * ui) * (1 - uo * uo) * (d[0] + d[1] * ui) * (d[0] + d[1] * uo) /
                (kPi * (ui + uo))};
  }

  /// f_k^(0), f_k^(1) for k = 2, 3.
  [[nodiscard]] std::array<double, 2> higher_order(int k, double ui, double uo) const {
    const auto& a = k == 2 ? c_.c20 : c_.c30;
    const auto& b = k == 2 ? c_.c21 : c_.c31;
    const double product = ui * uo, sum = ui + uo;
    return {(a[0] + a[1] * product + a[2] * sum + a[3] * product * product +
             a[4] * (ui * ui + uo * uo)) /
                (kPi * sum),
            sines(ui, uo) / (kPi * sum) * (b[0] + b[1] * product + b[2] * sum)};
  }

 private:
  double alpha_;
  Coefficients c_;
};

/// The factors of f_m that depend on albedo and roughness alone.
struct HigherOrders {
  double scale, offset;

  HigherOrders(double c, double r) {
    const double s = std::sqrt(1 - c);
    const double ck = (1 - 0.453 * (1 - c) - 0.544 * s) / (1.429 * s + 1);
    const double ca =
        c * std::pow(1.169 * s + 1, -std::atan((r - 0.265) * r + 0.0225) * std::erf(s));
    scale = 0.384 * ck * (ca - 0.342) * ca;
    offset = std::abs(std::tanh(r) - 0.09);
  }
  [[nodiscard]] double operator()(double ui, double uo) const {
    return scale * (offset - 0.0579 / (ui * uo + 0.288));
  }
};

/// a + b x + c x^2 with x = cos phi, of which only the positive part may count.
struct CosineQuadratic {
  double a, b, c;

  [[nodiscard]] double operator()(double x) const { return a + (b + c * x) * x; }

  /// Integral over phi in (0, 2 pi).
  [[nodiscard]] double integral() const { return 2 * kPi * (a + c / 2); }

  /// Integral over phi of the positive part: between the zeros it is elementary.
  [[nodiscard]] double positive_integral() const {
    std::array<double, 4> ends{-1, -1, -1, 1};
    const double root = b * b - 4 * a * c;
    if (root >= 0) {
      const double q = -0.5 * (b + std::copysign(std::sqrt(root), b));
      const auto inside = [](double x) { return x > -1 && x < 1 ? x : -1; };
      ends[1] = inside(q / c);
      ends[2] = inside(a / q);
      std::sort(ends.begin(), ends.end());
    }
    const auto antiderivative = [&](double x) {  // over phi from x = cos phi to x = 1
      const double phi = std::acos(x), s = std::sqrt((1 - x) * (1 + x));
      return (a + c / 2) * phi + (b + c / 2 * x) * s;
    };
    double sum = 0;
    for (int k = 0; k < 3; ++k)
      if (ends[k] < ends[k + 1] && (*this)((ends[k] + ends[k + 1]) / 2) > 0)
        sum += antiderivative(ends[k]) - antiderivative(ends[k + 1]);
    return 2 * sum;
  }
};

class VmfDiffuse final : public Model {
 public:
  VmfDiffuse(Rgb albedo, double roughness, bool printed, HemisphereSampler sampler)
      : Model(4),
        roughness_(roughness),
        sampler_(sampler),
        albedo_(albedo),
        modes_(roughness),
        higher_{HigherOrders(albedo.r, roughness), HigherOrders(albedo.g, roughness),
                HigherOrders(albedo.b, roughness)},
        printed_(printed),
        lambert_(!printed && roughness == 0) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    if (lambert_) return lobe == 0 ? 1 / kPi * albedo_ : Rgb();
    if (lobe == 3) return highest(a->mu_i, a->mu_o);
    return clamped(around(lobe + 1, a->mu_i, a->mu_o)(a->cos_phi)) * weight(lobe + 1);
  }

  /// The azimuth in closed form, the cosine by adaptive quadrature: relative error below 1e-8.
  [[nodiscard]] Rgb albedo(Direction wi) const override {
    if (wi.z < 0) return Rgb();
    if (lambert_) return albedo_;
    const double ui = std::max(wi.z, kGrazingLimit);
    Rgb sum;
    for (int order = 1; order <= 3; ++order)
      sum += over_cosines([&](double uo) {
               const CosineQuadratic f = around(order, ui, uo);
               return printed_ ? f.integral() : f.positive_integral();
             }) *
             weight(order);
    for (int c = 0; c < 3; ++c)
      sum[c] += over_cosines([&](double uo) { return 2 * kPi * clamped(higher_[c](ui, uo)); });
    return sum;
  }

  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    if (wo.z < 0) return Model::sample(wo, u1, u2, u3);
    return frame_towards(wo).to_world(
        vmf_diffuse_sampling_lobe(wo.z, roughness_).sample(sampler_, u1, u2, u3));
  }

  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    if (wo.z < 0) return Model::pdf(wi, wo);
    return vmf_diffuse_sampling_lobe(wo.z, roughness_)
        .pdf(sampler_, frame_towards(wo).to_local(wi));
  }

 private:
  [[nodiscard]] double clamped(double f) const { return printed_ || f > 0 ? f : 0; }
  /// The factor of the modes' cosines.
  [[nodiscard]] double fold() const { return printed_ ? 1 : 2; }
  [[nodiscard]] Rgb weight(int order) const {
    return order == 1 ? albedo_ : albedo_ * weight(order - 1);
  }
  /// f_1, f_2 or f_3 as a function of cos phi.
  [[nodiscard]] CosineQuadratic around(int order, double ui, double uo) const {
    if (order == 1) {
      const auto f = modes_.first_order(ui, uo);
      return {f[0] - fold() * f[2], fold() * f[1], 2 * fold() * f[2]};
    }
    const auto f = modes_.higher_order(order, ui, uo);
    return {f[0], fold() * f[1], 0};
  }
  [[nodiscard]] Rgb highest(double ui, double uo) const {
    return {clamped(higher_[0](ui, uo)), clamped(higher_[1](ui, uo)), clamped(higher_[2](ui, uo))};
  }
  template <class F>
  [[nodiscard]] static double over_cosines(const F& f) {
    using boost::math::quadrature::gauss_kronrod;
    const auto g = [&](double u) { return u * f(u); };
    return gauss_kronrod<double, 31>::integrate(g, 0.0, 0.1, 8, 1e-9) +
           gauss_kronrod<double, 31>::integrate(g, 0.1, 1.0, 8, 1e-9);
  }

  double roughness_;
  HemisphereSampler sampler_;
  Rgb albedo_;
  Modes modes_;
  std::array<HigherOrders, 3> higher_;
  bool printed_;
  bool lambert_;
};

ModelInfo info(std::string name, std::string doc, bool printed) {
  return {.name = std::move(name),
          .doc = std::move(doc),
          .source = "d'Eon and Weidlich 2024, VMF Diffuse: A unified rough diffuse BRDF",
          .parameters = {albedo_parameter("albedo of the Lambertian flakes"),
                         {.name = "roughness",
                          .unit = "1",
                          .doc = "r; 0: Lambert's surface, 1: Lambert spheres",
                          .default_value = "0.5",
                          .min = 0,
                          .max = 1},
                         sampler_parameter()},
          .lobes = {{"f1", "one event", Order::one},
                    {"f2", "two events", Order::two},
                    {"f3", "three events", Order::three},
                    {"fm", "four events and more", Order::four_plus}},
          .make =
              [printed](const Parameters& p, const Stack*) {
                return std::make_unique<VmfDiffuse>(p.color("albedo"), p.number("roughness"),
                                                    printed, sampler_of(p));
              },
          .applies_to = [](const Stack& stack) -> std::optional<Parameters> {
            const Layer* layer = only_half_space(stack);
            const auto* flakes = layer ? std::get_if<LambertFlakes<Vmf>>(&layer->medium) : nullptr;
            if (!flakes || !(flakes->ndf.axis() == Direction{0, 0, 1})) return std::nullopt;
            const double root = -std::expm1(-flakes->ndf.alpha());  // inverse of vmf_alpha
            Parameters p;
            p.set("albedo", layer->albedo);
            p.set("roughness", layer->parameters.has("roughness")
                                   ? layer->parameters.number("roughness")
                                   : root * root);
            return p;
          }};
}

}  // namespace

double vmf_diffuse_mode(int order, int m, double roughness, double u_i, double u_o) {
  const Modes modes(roughness);
  if (order == 1) return modes.first_order(u_i, u_o)[m];
  return m < 2 ? modes.higher_order(order, u_i, u_o)[m] : 0;
}

double vmf_diffuse_higher_orders(double albedo, double roughness, double u_i, double u_o) {
  return HigherOrders(albedo, roughness)(u_i, u_o);
}

double vmf_diffuse_albedo(double k_d, double roughness) {
  const double s = 0.64985 + (0.631112 + 1.38922 * roughness) * roughness;
  const double w = std::sqrt(roughness);
  // The root of the quadratic without the cancellation at small k_d.
  const double rough = 2 * s * k_d / (1 - k_d + std::hypot(1 - k_d, 2 * s * k_d));
  return w * rough + (1 - w) * k_d;
}

ModelInfo vmf_diffuse_model() {
  return info("vmf_diffuse", "rough diffuse half space of von Mises-Fisher flakes", false);
}

ModelInfo vmf_diffuse_printed_model() {
  return info("vmf_diffuse_printed", "vmf_diffuse with the formulas as printed", true);
}

}  // namespace lamella
