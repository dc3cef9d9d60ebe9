#include "compare/bench/textbook_models.h"

#include <cmath>

#include "analytic/half_space/lambert_sphere_formula.h"
#include "analytic/half_space/vmf_diffuse_formula.h"

namespace lamella {
namespace {

// The loop, around a function that the compiler can see.
template <class F>
class TextbookLoop final : public TextbookModel {
 public:
  explicit TextbookLoop(const F& f) : f_(f) {}
  void eval(std::span<const DirectionPair> pairs, std::span<double> values) const override {
    for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = f_(pairs[k].wi, pairs[k].wo);
  }

 private:
  F f_;
};

template <class F>
std::unique_ptr<TextbookModel> loop_of(const F& f) {
  return std::make_unique<TextbookLoop<F>>(f);
}

// EON's listing: eqs. 11 to 19.
enum class TextbookAlbedo { none, exact, fit };

template <TextbookAlbedo kAlbedo>
struct TextbookEon {
  double rho, r, a, average, multiple;

  TextbookEon(double albedo, double roughness) : rho(albedo), r(roughness) {
    a = 1 / (1 + (0.5 - 2 / (3 * kPi)) * r);
    average = a * (1 + (2.0 / 3 - 28 / (15 * kPi)) * r);
    multiple = rho * rho * average / (1 - rho * (1 - average)) / kPi;
  }
  [[nodiscard]] double directional_albedo(double mu) const {
    if constexpr (kAlbedo == TextbookAlbedo::fit) {
      const double x = 1 - mu;
      return a *
             (1 +
              r * x * (0.0571085289 + x * (0.491881867 + x * (-0.332181442 + x * 0.0714429953))));
    } else {
      const double s = std::sqrt(1 - mu * mu);
      const double g = s * (std::acos(mu) - s * mu) + 2.0 / 3 * (s / mu * (1 - s * s * s) - s);
      return a + a * r / kPi * g;
    }
  }
  double operator()(Direction wi, Direction wo) const {
    const double s = dot(wi, wo) - wi.z * wo.z;
    const double single = rho / kPi * a * (1 + r * (s > 0 ? s / std::max(wi.z, wo.z) : s));
    if constexpr (kAlbedo == TextbookAlbedo::none) return single;
    constexpr double kSmall = 1e-7;
    return single + multiple * std::max(kSmall, 1 - directional_albedo(wi.z)) *
                        std::max(kSmall, 1 - directional_albedo(wo.z)) /
                        std::max(kSmall, 1 - average);
  }
};

// d'Eon 2021: eqs. 1, 17, 29, 35, 37, 45, with the corrections of analytic/README.md.
struct TextbookLambertSphere {
  AnalyticLambertSphere::Channel k;

  double h0(double mu) const {
    const double power = k.h0.a * std::pow(mu, k.h0.d);
    return (1 + power) / (1 + power * k.h0.limit);
  }
  double h1(double mu) const {
    return std::exp(k.h1 *
                    std::pow(mu, ((-1.12831 * mu + 1.85728) * mu - 1.07879) * mu + 0.459442));
  }
  double operator()(Direction wi, Direction wo) const {
    const double x = wi.z, y = wo.z, sum = x + y, product = x * y;
    const double cosine = std::clamp(-dot(wi, wo), -1.0, 1.0);
    const double theta = std::acos(cosine);
    const double phase = 2 * (std::sqrt(1 - cosine * cosine) - theta * cosine) / (3 * kPi * kPi);
    const double sines_cos = dot(wi, wo) - product;
    const double f0 = h0(x) * h0(y) / (2 * kPi * sum) *
                      (k.a + (k.b + k.d * product) * sum + (k.c + k.e * product) * product +
                       k.f * (x * x + y * y));
    const double f1 =
        k.albedo * h1(x) * h1(y) / (3 * kPi * sum) * sines_cos * (1 + k.n * product + k.l * sum);
    const double p2x = 1.5 * x * x - 0.5, p2y = 1.5 * y * y - 0.5;
    const double mean = (k.albedo - k.w1 * product + k.w2 * p2x * p2y) / (4 * kPi * sum);
    const double slope = -(k.w1 - 3 * k.w2 * product) * sines_cos / (4 * kPi * sum);
    return k.albedo * phase / sum + f0 + f1 - mean - slope;
  }
};

// d'Eon and Weidlich 2024: eqs. 4 to 9 and appendix A, with the corrections of analytic/README.md.
struct TextbookVmf {
  VmfModeFormula k;
  double c, scale, offset;

  double sigma(double u) const {
    const double u2 = u * u, u4 = u2 * u2;
    switch (k.sigma.range) {
      case VmfSigmaFit::Range::smooth: {
        const double a = k.sigma.smooth.alpha, t = k.sigma.smooth.tanh;
        const double width = a * std::sqrt(1 - u2), x = u / width;
        return 0.25 * (t * (u - a * a * std::abs(u)) - (a * a + 2) * u + u / t) +
               0.5 * (u * (std::erf(x) + 1) + width * std::exp(-x * x) / std::sqrt(kPi));
      }
      case VmfSigmaFit::Range::middle: {
        const VmfMiddleSigma& m = k.sigma.middle;
        return 0.25 + m.p1 * u + m.p2 * (3 * u2 - 1) - m.p4 * (3 - 30 * u2 + 35 * u4) +
               m.p8 * u4 * u4 - m.wave * std::cos(7.7 * u);
      }
      default:
        return 0.25 + k.sigma.rough.mean * u + k.sigma.rough.second * (3 * u2 - 1);
    }
  }
  double operator()(Direction wi, Direction wo) const {
    const double x = wi.z, y = wo.z, sum = x + y, product = x * y, squares = x * x + y * y;
    const double si = sigma(x), so = sigma(y);
    const double denominator = kPi * (x * sigma(-y) + y * si);
    const double s2 = (1 - x * x) * (1 - y * y), sines = std::sqrt(s2);
    const double cos_phi = sines > 0 ? (dot(wi, wo) - product) / sines : 1;
    const double cos_2phi = 2 * cos_phi * cos_phi - 1;
    const double f10 =
        si * so / denominator *
        (k.c10[0] + k.c10[1] * product + k.c10[2] * product * product + k.c10[3] * squares);
    const double f11 =
        std::pow(si * so, k.c11[2]) / denominator * sines * (k.c11[0] + k.c11[1] * product);
    const double f12 = s2 * (k.c12[0] + k.c12[1] * x) * (k.c12[0] + k.c12[1] * y) / (kPi * sum);
    const auto higher = [&](const double(&a)[5], const double(&b)[3]) {
      const double m0 =
          (a[0] + a[1] * product + a[2] * sum + a[3] * product * product + a[4] * squares) /
          (kPi * sum);
      const double m1 = sines / (kPi * sum) * (b[0] + b[1] * product + b[2] * sum);
      return std::max(0.0, m0 + 2 * m1 * cos_phi);
    };
    return c * std::max(0.0, f10 + 2 * f11 * cos_phi + 2 * f12 * cos_2phi) +
           c * c * higher(k.c20, k.c21) + c * c * c * higher(k.c30, k.c31) +
           std::max(0.0, scale * (offset - 0.0579 / (product + 0.288)));
  }
};

}  // namespace

std::unique_ptr<TextbookModel> textbook_model(const std::string& name,
                                              const Parameters& parameters) {
  const auto albedo = [&] { return parameters.color("albedo").g; };
  const auto roughness = [&] { return parameters.number("roughness"); };
  if (name == "fon") return loop_of(TextbookEon<TextbookAlbedo::none>(albedo(), roughness()));
  if (name == "eon") return loop_of(TextbookEon<TextbookAlbedo::exact>(albedo(), roughness()));
  if (name == "eon_approx") return loop_of(TextbookEon<TextbookAlbedo::fit>(albedo(), roughness()));
  if (name == "lambert_sphere")
    return loop_of(TextbookLambertSphere{lambert_sphere_formula(Rgb(albedo())).channels[0]});
  if (name == "vmf_diffuse" && roughness() > 0) {
    const VmfDiffuseFormula f = vmf_diffuse_formula(Rgb(albedo()), roughness(), false);
    return loop_of(TextbookVmf{f.modes, albedo(), f.channels[0].scale, f.offset});
  }
  return nullptr;
}

}  // namespace lamella
