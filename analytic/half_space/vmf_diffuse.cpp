#include "analytic/half_space/vmf_diffuse.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>

#include "analytic/half_space/half_space_lanes.h"
#include "analytic/half_space/vmf_diffuse_sampler.h"
#include "analytic/model/formula_model.h"
#include "analytic/model/one_half_space.h"

namespace lamella {
namespace {

double vmf_sines(double ui, double uo) {
  return std::sqrt((1 - ui) * (1 + ui) * (1 - uo) * (1 + uo));
}

VmfModes<double> modes_of(const VmfModeFormula& f, int order, double ui, double uo) {
  return order == 1   ? f.first_order(ui, uo)
         : order == 2 ? f.higher_order(f.c20, f.c21, ui, uo)
                      : f.higher_order(f.c30, f.c31, ui, uo);
}

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

class VmfDiffuse final : public FormulaModel<VmfDiffuseFormula> {
 public:
  VmfDiffuse(Rgb albedo, double roughness, bool printed, HemisphereSampler sampler)
      : FormulaModel(4, vmf_diffuse_formula(albedo, roughness, printed), albedo.is_grey(),
                     vmf_diffuse_batch_for),
        roughness_(roughness),
        sampler_(sampler),
        albedo_(albedo),
        printed_(printed),
        lambert_(!printed && roughness == 0) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    if (lambert_) return lobe == 0 ? 1 / kPi * albedo_ : Rgb();
    const auto s = formula_.shared(*a);
    if (lobe == 3) return per_channel([&](int c) { return formula_.highest(s.fm, c); });
    return (lobe == 0 ? s.f1 : lobe == 1 ? s.f2 : s.f3) * weight(lobe + 1);
  }

  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override {
    return lambert_ ? eval_lobe(0, wi, wo) : FormulaModel::eval(wi, wo);
  }
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa) const override {
    // Each pair by the eval above, not the formula's lanes.
    // NOLINTNEXTLINE(bugprone-parent-virtual-call)
    lambert_ ? Model::eval(pairs, values, isa) : FormulaModel::eval(pairs, values, isa);
  }

  /// The azimuth in closed form, the cosine by adaptive quadrature: relative error below 1e-8.
  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    if (lambert_) return exact_albedo(albedo_);
    const double ui = std::max(wi.z, kGrazingLimit);
    Rgb sum;
    for (int order = 1; order <= 3; ++order)
      sum += over_cosines([&](double uo) {
               const CosineQuadratic f = around(order, ui, uo);
               return printed_ ? f.integral() : f.positive_integral();
             }) *
             weight(order);
    sum += per_channel([&](int c) {
      return over_cosines(
          [&](double uo) { return 2 * kPi * formula_.highest(formula_.higher_orders(ui, uo), c); });
    });
    AlbedoEstimate albedo{sum, {}, {}};
    for (int c = 0; c < 3; ++c) albedo.error[c] = 1e-8 * std::abs(sum[c]);
    return albedo;
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
  [[nodiscard]] Rgb weight(int order) const {
    return order == 1 ? albedo_ : albedo_ * weight(order - 1);
  }
  /// f_1, f_2 or f_3 as a function of cos phi.
  [[nodiscard]] CosineQuadratic around(int order, double ui, double uo) const {
    const VmfModes<double> f = modes_of(formula_.modes, order, ui, uo);
    const double sines = vmf_sines(ui, uo), bend = formula_.fold * f.bend * sines * sines;
    return {f.mean - bend, formula_.fold * f.slope * sines, 2 * bend};
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
  bool printed_;
  bool lambert_;
};

std::vector<PartInfo> parts() {
  std::vector<PartInfo> list{
      {"sigma", "fitted cross section of flakes of albedo 1 seen from w_i, relative to their area",
       [](const Parameters& p, Direction wi, Direction) {
         return Rgb(vmf_sigma_fit(wi.z, vmf_alpha(p.number("roughness"))));
       }},
      {"albedo_map",
       "flake albedo for the diffuse albedo that is given as `albedo`, section 5; of no direction",
       [](const Parameters& p, Direction, Direction) {
         const Rgb k = p.color("albedo");
         const double r = p.number("roughness");
         return Rgb(vmf_diffuse_albedo(k.r, r), vmf_diffuse_albedo(k.g, r),
                    vmf_diffuse_albedo(k.b, r));
       }}};
  for (int order = 1; order <= 3; ++order)
    for (int m = 0; m <= (order == 1 ? 2 : 1); ++m)  // the others are 0
      list.push_back(
          {fmt::format("f{}_mode{}", order, m),
           fmt::format(
               "printed azimuthal mode {} of order {} at albedo 1, without its cosine [1/sr]", m,
               order),
           [order, m](const Parameters& p, Direction wi, Direction wo) {
             return Rgb(vmf_diffuse_mode(order, m, p.number("roughness"),
                                         std::max(std::abs(wi.z), kGrazingLimit),
                                         std::max(std::abs(wo.z), kGrazingLimit)));
           }});
  return list;
}

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
          },
          .parts = parts()};
}

}  // namespace

double vmf_diffuse_mode(int order, int m, double roughness, double u_i, double u_o) {
  const VmfModes<double> f = modes_of(vmf_mode_formula(roughness), order, u_i, u_o);
  const double sines = vmf_sines(u_i, u_o);
  return m == 0 ? f.mean : m == 1 ? f.slope * sines : f.bend * sines * sines;
}

double vmf_diffuse_higher_orders(double albedo, double roughness, double u_i, double u_o) {
  const VmfDiffuseFormula f = vmf_diffuse_formula(Rgb(albedo), roughness, true);
  return f.highest(f.higher_orders(u_i, u_o), 0);
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
