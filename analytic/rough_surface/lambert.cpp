#include "analytic/rough_surface/lambert.h"

namespace lamella {
namespace {

class Lambert final : public Model {
 public:
  explicit Lambert(Rgb albedo) : Model(1), albedo_(albedo) {}

  [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction wi, Direction wo) const override {
    return (wi.z < 0) == (wo.z < 0) ? (1 / kPi) * albedo_ : Rgb();
  }
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values,
            Isa /*isa*/) const override {
    const Rgb f = 1 / kPi * albedo_;
    for (std::size_t k = 0; k < pairs.size(); ++k)
      values[k] = (pairs[k].wi.z < 0) == (pairs[k].wo.z < 0) ? f : Rgb();
  }
  [[nodiscard]] AlbedoEstimate albedo_with_error(Direction /*wi*/) const override {
    return exact_albedo(albedo_);
  }

 private:
  Rgb albedo_;
};

}  // namespace

ModelInfo lambert_model() {
  return {.name = "lambert",
          .doc = "perfectly diffuse reflection, albedo / pi",
          .source = "Lambert 1760",
          .parameters = {{.name = "albedo",
                          .kind = ParameterKind::color,
                          .unit = "1",
                          .doc = "directional albedo",
                          .default_value = "1",
                          .min = 0,
                          .max = 1}},
          .lobes = {{.name = "diffuse", .doc = "all of it"}},
          .make = [](const Parameters& p,
                     const Stack*) { return std::make_unique<Lambert>(p.color("albedo")); },
          .applies_to = {}};
}

}  // namespace lamella
