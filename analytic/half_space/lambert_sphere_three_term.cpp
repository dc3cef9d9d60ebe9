#include "analytic/half_space/lambert_sphere_three_term.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "analytic/half_space/lambert_sphere_models.h"
#include "analytic/half_space/three_term.h"
#include "analytic/model/one_half_space.h"

namespace lamella {
namespace {

class LambertSphereThreeTerm final : public Model {
 public:
  LambertSphereThreeTerm(Rgb albedo, bool exact_single)
      : Model(2), albedo_(albedo), exact_single_(exact_single) {
    for (int c = 0; c < (albedo.is_grey() ? 1 : 3); ++c)
      half_spaces_.emplace_back(lambert_sphere_phase_terms(albedo[c]));
  }

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const double truncated = three_term_single(kWhite, *a);
    if (lobe == 0) return (exact_single_ ? lambert_sphere_single(*a) : truncated) * albedo_;
    return total(*a) - truncated * albedo_;
  }

  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    return exact_single_ ? total(*a) + correction(*a) * albedo_ : total(*a);
  }

  /// The three-term albedo in closed form; what order 1 adds to it by quadrature.
  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction wi) const override {
    if (wi.z < 0) return {};
    const auto three_term = [&](int c) { return half_spaces_[c].albedo(wi.z); };
    const Rgb sum = half_spaces_.size() == 1 ? Rgb(three_term(0))
                                             : Rgb(three_term(0), three_term(1), three_term(2));
    double error = 1e-10;  // of ThreeTermHalfSpace
    for (int c = 0; c < 3; ++c)
      if (const double rest = 1 - albedo_[c]; rest > 0 && rest < 1e-8)
        error = std::max(error, std::min(1e-7, 1e-14 / std::sqrt(rest)));
    if (!exact_single_) return exact_albedo(sum, error);
    const auto f = [&](std::span<const Direction> directions, std::span<Rgb> values) {
      for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = correction(*reflection_angles(wi, directions[k])) * albedo_;
    };
    const DirectionalIntegral added = integrate_projected(f, wi, std::array{1.0});
    const AlbedoEstimate exact = exact_albedo(sum, error);
    return {exact.value + added.value, exact.error + added.error, added.end};
  }

 private:
  inline static const ThreeTermPhase kWhite = lambert_sphere_phase_terms(1);

  [[nodiscard]] Rgb total(const ReflectionAngles& a) const {
    if (half_spaces_.size() == 1) return Rgb(half_spaces_[0](a));
    return {half_spaces_[0](a), half_spaces_[1](a), half_spaces_[2](a)};
  }
  /// Exact less truncated single scattering for c = 1.
  [[nodiscard]] static double correction(const ReflectionAngles& a) {
    return lambert_sphere_single(a) - three_term_single(kWhite, a);
  }

  Rgb albedo_;
  bool exact_single_;
  std::vector<ThreeTermHalfSpace> half_spaces_;  // one if grey, otherwise per channel
};

PartInfo h_part(int mode) {
  return part_of_albedo(fmt::format("h{}", mode),
                        fmt::format("H of w_i in azimuthal mode {}, exact", mode),
                        [mode](double c, double mu) {
                          return ThreeTermHalfSpace(lambert_sphere_phase_terms(c)).h(mode)(mu);
                        });
}

std::vector<PartInfo> parts() {
  std::vector<PartInfo> list{h_part(0), h_part(1), h_part(2)};
  for (PartInfo& part : constant_parts("exact", exact_lambert_sphere_constants))
    list.push_back(std::move(part));
  return list;
}

ModelInfo info(std::string name, std::string doc, bool exact_single) {
  return {.name = std::move(name),
          .doc = std::move(doc),
          .source =
              "Horak and Chandrasekhar 1961, Diffuse Reflection by a Semi-Infinite "
              "Atmosphere; d'Eon 2021",
          .parameters = {albedo_parameter("albedo of the Lambertian spheres")},
          .lobes = {{"single", "one event", Order::one},
                    {"multiple", "two events and more", Order::all}},
          .make =
              [exact_single](const Parameters& p, const Stack*) {
                return std::make_unique<LambertSphereThreeTerm>(p.color("albedo"), exact_single);
              },
          .applies_to = lambert_sphere_parameters,
          .parts = parts()};
}

}  // namespace

ModelInfo lambert_sphere_three_term_model() {
  return info("lambert_sphere_three_term",
              "half space of Lambertian spheres: exact single scattering, exact three-term "
              "multiple scattering",
              true);
}

ModelInfo lambert_sphere_three_term_pure_model() {
  return info("lambert_sphere_three_term_pure",
              "half space with the first three Legendre terms of the Lambertian sphere, exact",
              false);
}

}  // namespace lamella
