#include "analytic/layered/spongecake.h"

#include <fmt/format.h>

#include <algorithm>

#include "analytic/layered/single_scattering_model.h"
#include "phase/medium/media.h"

namespace lamella {
namespace {

class Spongecake final : public Model {
 public:
  Spongecake(const Stack& stack, Stack second, Rgb weight, Rgb reflect, Rgb transmit)
      : Model(4),
        single_(stack),
        second_(std::move(second)),
        weight_(weight),
        reflect_(1 / kPi * reflect),
        transmit_(stack.is_open_below() ? 1 / kPi * transmit : Rgb()) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    if (lobe < 2) return single_.eval_lobe(lobe, wi, wo);
    if (lobe == 3) return (wi.z < 0) == (wo.z < 0) ? reflect_ : transmit_;
    return weight_ == Rgb() ? Rgb() : weight_ * single_scattering(second_, wi, wo).layers;
  }
  void eval_lobes(Direction wi, Direction wo, std::span<Rgb> values) const override {
    single_.eval_lobes(wi, wo, values.first(2));
    values[2] = eval_lobe(2, wi, wo);
    values[3] = eval_lobe(3, wi, wo);
  }
  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override {
    return single_.eval(wi, wo) + eval_lobe(2, wi, wo) + eval_lobe(3, wi, wo);
  }
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override {
    return single_.sample(wo, u1, u2, u3);
  }
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override {
    return single_.pdf(wi, wo);
  }
  [[nodiscard]] double uncollided(Direction wi) const override { return single_.uncollided(wi); }

 private:
  SingleScatteringModel single_;
  Stack second_;
  Rgb weight_, reflect_, transmit_;
};

ParameterInfo factor(std::string name, std::string doc, ParameterKind kind, double min,
                     std::string default_value) {
  return {.name = std::move(name),
          .kind = kind,
          .unit = "1",
          .doc = std::move(doc),
          .default_value = std::move(default_value),
          .min = min,
          .max = 1e6};
}

ParameterInfo weight(std::string name, std::string doc) {
  return factor(std::move(name), std::move(doc), ParameterKind::color, 0, "0");
}

std::vector<ParameterInfo> lobe_parameters() {
  std::vector<ParameterInfo> list{
      {.name = "lobes",
       .kind = ParameterKind::choice,
       .unit = "1",
       .doc = "the two further lobes: fitted to the stack unless their keys are given; none",
       .default_value = "fitted",
       .choices = {"fitted", "given", "none"}},
      weight("second_weight", "of the second single-scattering lobe; 0: none"),
      weight("lambert_reflect", "albedo of the constant lobe on the light's side"),
      weight("lambert_transmit", "albedo of the constant lobe on the other side")};
  for (int k = 1; k <= kSpongecakeLayers; ++k) {
    list.push_back(factor(fmt::format("second_roughness_{}", k),
                          fmt::format("second lobe: factor on the roughness or g of layer {}", k),
                          ParameterKind::number, -1e6, "1"));
    list.push_back(factor(fmt::format("second_depth_{}", k),
                          fmt::format("second lobe: factor on the depth of layer {}", k),
                          ParameterKind::number, 0, "1"));
    list.push_back(factor(fmt::format("second_albedo_{}", k),
                          fmt::format("second lobe: factor on the albedo of layer {}", k),
                          ParameterKind::color, 0, "1"));
  }
  return list;
}

}  // namespace

bool is_spongecake_stack(const Stack& stack) {
  if (stack.grains() || stack.has_boundaries()) return false;
  return std::all_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
    if (layer.grid) return false;
    return std::holds_alternative<MirrorFlakes<Sggx>>(layer.medium) ||
           std::holds_alternative<HenyeyGreenstein>(layer.medium);
  });
}

Stack spongecake_second_stack(const Stack& stack, std::span<const SpongecakeFactors> factors) {
  Stack second = stack;
  second.substrate.reset();
  for (std::size_t k = 0; k < std::min(factors.size(), second.layers.size()); ++k) {
    Layer& layer = second.layers[k];
    const SpongecakeFactors& f = factors[k];
    layer.albedo = f.albedo * layer.albedo;
    layer.density *= f.depth;
    if (f.roughness == 1) continue;
    const char* key = std::holds_alternative<HenyeyGreenstein>(layer.medium) ? "g" : "roughness";
    if (!layer.parameters.has(key))
      throw ParameterError(fmt::format("second_roughness_{}", k + 1), to_text(f.roughness),
                           "1 for a layer given by a matrix");
    const MediumInfo& info = *find_medium(layer.medium_name);
    layer.parameters.set(
        key, checked(*find(info.parameters, key), layer.parameters.number(key) * f.roughness));
    layer.medium = info.make(layer.parameters);
  }
  return second;
}

ModelInfo spongecake_model() {
  return {.name = "spongecake",
          .doc =
              "SGGX mirror flakes and Henyey-Greenstein layers: single scattering, and two lobes "
              "for the rest",
          .source = "Wang et al. 2022, SpongeCake, sections 4 and 5",
          .parameters = lobe_parameters(),
          .lobes = {{"single", "one event in one of the layers", Order::one},
                    {"substrate", "one reflection from the substrate", Order::one},
                    {"second", "the second single-scattering lobe", Order::all},
                    {"lambert", "the constant lobe", Order::all}},
          .reciprocal = true,
          .transmits = true,
          .needs_stack = true,
          .make = [](const Parameters& p, const Stack* stack) -> std::unique_ptr<Model> {
            if (!is_spongecake_stack(*stack))
              throw ParameterError("stack", stack->name,
                                   "a stack of homogeneous layers of SGGX mirror flakes and "
                                   "Henyey-Greenstein particles");
            std::vector<SpongecakeFactors> factors;
            for (int k = 1; k <= kSpongecakeLayers; ++k)
              factors.push_back({p.number(fmt::format("second_roughness_{}", k)),
                                 p.number(fmt::format("second_depth_{}", k)),
                                 p.color(fmt::format("second_albedo_{}", k))});
            const bool off = p.color("second_weight") == Rgb() &&
                             p.color("lambert_reflect") == Rgb() &&
                             p.color("lambert_transmit") == Rgb();
            if (p.choice("lobes") == "none" && !off)
              throw ParameterError("lobes", "\"none\" beside a lobe that is not 0",
                                   "fitted, given, or no key of a lobe");
            return std::make_unique<Spongecake>(
                *stack, spongecake_second_stack(*stack, factors), p.color("second_weight"),
                p.color("lambert_reflect"), p.color("lambert_transmit"));
          },
          .applies_to =
              [](const Stack& stack) {
                return is_spongecake_stack(stack) ? std::optional(Parameters()) : std::nullopt;
              }};
}

}  // namespace lamella
