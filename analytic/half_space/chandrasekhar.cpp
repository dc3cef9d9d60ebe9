#include "analytic/half_space/chandrasekhar.h"

#include "analytic/half_space/h_function.h"
#include "analytic/model/one_half_space.h"
#include "analytic/model/reflection_angles.h"

namespace lamella {
namespace {

class Chandrasekhar final : public Model {
 public:
  explicit Chandrasekhar(Rgb albedo) : Model(2), albedo_(albedo) {
    for (int c = 0; c < (albedo.is_grey() ? 1 : 3); ++c) h_.push_back(isotropic_h(albedo[c]));
  }

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const Rgb single = 1 / (4 * kPi * (a->mu_i + a->mu_o)) * albedo_;
    return lobe == 0 ? single : single * (product(*a) - Rgb(1));
  }

  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    return 1 / (4 * kPi * (a->mu_i + a->mu_o)) * albedo_ * product(*a);
  }

  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    return exact_albedo(
        per_channel([&](int c) { return 1 - std::sqrt(1 - albedo_[c]) * h_[c](wi.z); }), 1e-11);
  }

 private:
  template <class F>
  [[nodiscard]] Rgb per_channel(const F& f) const {
    return h_.size() == 1 ? Rgb(f(0)) : Rgb(f(0), f(1), f(2));
  }
  [[nodiscard]] Rgb product(const ReflectionAngles& a) const {
    return per_channel([&](int c) { return h_[c](a.mu_i) * h_[c](a.mu_o); });
  }

  Rgb albedo_;
  std::vector<HFunction> h_;  // one if grey, otherwise per channel
};

bool is_isotropic(const Layer& layer) {
  if (const auto* hg = std::get_if<HenyeyGreenstein>(&layer.medium)) return hg->g == 0;
  const auto* flakes = std::get_if<MirrorFlakes<Sggx>>(&layer.medium);
  if (!flakes || !(layer.f0 == Rgb(1))) return false;
  const SggxMatrix<double>& a = flakes->ndf.matrix();
  return a.a00 == 1 && a.a11 == 1 && a.a22 == 1 && a.a10 == 0 && a.a20 == 0 && a.a21 == 0;
}

}  // namespace

ModelInfo chandrasekhar_model() {
  return {
      .name = "chandrasekhar",
      .doc = "half space of isotropic scatterers, exact",
      .source = "Chandrasekhar 1960, Radiative Transfer; d'Eon 2021, eq. 21",
      .parameters = {albedo_parameter("single-scattering albedo")},
      .lobes = {{"single", "one event", Order::one},
                {"multiple", "two events and more", Order::all}},
      .make = [](const Parameters& p,
                 const Stack*) { return std::make_unique<Chandrasekhar>(p.color("albedo")); },
      .applies_to = [](const Stack& stack) -> std::optional<Parameters> {
        const Layer* layer = only_half_space(stack);
        if (!layer || !is_isotropic(*layer)) return std::nullopt;
        Parameters p;
        p.set("albedo", layer->albedo);
        return p;
      },
      .parts = {part_of_albedo("h", "H of w_i, exact",
                               [](double c, double mu) { return isotropic_h(c)(mu); }),
                part_of_albedo("h_hapke_1981", "H of w_i by Hapke's rational form",
                               [](double c, double mu) { return isotropic_h_hapke_1981(mu, c); }),
                part_of_albedo("h_hapke_2002", "H of w_i by Hapke's form with a logarithm",
                               [](double c, double mu) { return isotropic_h_hapke_2002(mu, c); }),
                part_of_albedo("h_moment0", "integral of H over mu in (0, 1); of no direction",
                               [](double c, double) { return isotropic_h(c).moment(0); }),
                part_of_albedo("h_moment1", "integral of mu H; of no direction",
                               [](double c, double) { return isotropic_h(c).moment(1); })}};
}

}  // namespace lamella
