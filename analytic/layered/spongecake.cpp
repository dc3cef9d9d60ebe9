#include "analytic/layered/spongecake.h"

#include <fmt/format.h>

#include <algorithm>

#include "analytic/layered/single_scattering_model.h"
#include "analytic/spongecake_network/spongecake_network.h"
#include "analytic/spongecake_network/spongecake_ranges.h"
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
       .doc = "where the two further lobes come from; auto: given with a key of theirs, else "
              "network for one and two layers within its ranges, else fit",
       .default_value = "auto",
       .choices = {"auto", "network", "fit", "given", "none"}},
      weight("second_weight", "W1, of the second single-scattering lobe; 0: none"),
      weight("lambert_reflect", "W2, albedo of the constant lobe on the light's side"),
      weight("lambert_transmit", "W2, albedo of the constant lobe on the other side")};
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
    list.push_back(factor(fmt::format("second_f0_{}", k),
                          fmt::format("second lobe: factor on Schlick's f0 of layer {}", k),
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
  if (factors.empty()) return second;
  for (std::size_t k = 0; k < second.layers.size(); ++k) {
    if (k >= factors.size() && factors.size() < kSpongecakeLayers) break;
    Layer& layer = second.layers[k];
    const SpongecakeFactors& f = factors[std::min(k, factors.size() - 1)];
    layer.albedo = f.albedo * layer.albedo;
    if (k < kSpongecakeLayers)
      for (int c = 0; c < 3; ++c) layer.f0[c] = std::min(1.0, f.f0[c] * layer.f0[c]);
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

namespace {

bool is_within(double x, const double (&range)[2]) { return x >= range[0] && x <= range[1]; }
bool is_within(Rgb x, const double (&range)[2]) {
  return is_within(x.r, range) && is_within(x.g, range) && is_within(x.b, range);
}

// The layers as the network reads them. Only where why_no_network is empty.
std::vector<NetworkLayer> network_layers(const Stack& stack) {
  std::vector<NetworkLayer> layers;
  for (const Layer& layer : stack.layers) {
    const Direction axis = layer.parameters.vector("axis");
    layers.push_back({.fiber = layer.parameters.choice("shape") == "fiber",
                      .roughness = layer.parameters.number("roughness"),
                      .axis = 1 / length(axis) * axis,
                      .depth = layer.depth(),
                      .albedo = layer.albedo,
                      .f0 = layer.f0});
  }
  return layers;
}

}  // namespace

std::string why_no_network(const Stack& stack) {
  if (!is_spongecake_stack(stack)) return "not a stack of SpongeCake's";
  if (stack.layers.empty() || stack.layers.size() > kNetworkLayers)
    return fmt::format("{} layers, and the networks are trained on one and two",
                       stack.layers.size());
  if (stack.substrate) return "a substrate, and the network is trained without";
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    const Parameters& p = layer.parameters;
    if (!std::holds_alternative<MirrorFlakes<Sggx>>(layer.medium))
      return fmt::format("layer {} is of particles, and the network is trained on flakes", k);
    if (!p.has("roughness") || !p.has("shape") || !p.has("axis"))
      return fmt::format("layer {} is given by a matrix", k);
    const auto outside = [&](const char* name, const auto& value, const double(&range)[2]) {
      return is_within(value, range)
                 ? std::string()
                 : fmt::format("{} {} of layer {} is outside of the trained {} to {}", name,
                               to_text(ParameterValue(value)), k, range[0], range[1]);
    };
    for (const std::string& reason :
         {outside("roughness", p.number("roughness"), SpongecakeRanges::kRoughness),
          outside("depth", layer.depth(), SpongecakeRanges::kDepth),
          outside("albedo", layer.albedo, SpongecakeRanges::kAlbedo),
          outside("f0", layer.f0, SpongecakeRanges::kF0)})
      if (!reason.empty()) return reason;
  }
  return {};
}

SpongecakeLobes predicted_lobes(const Stack& stack) {
  if (const std::string why = why_no_network(stack); !why.empty())
    throw ParameterError("lobes", fmt::format("network ({})", why), "fit, given, none or auto");
  const std::vector<NetworkLayer> layers = network_layers(stack);
  const PredictedLobes found = spongecake_network(static_cast<int>(layers.size())).predict(layers);
  SpongecakeLobes lobes{.factors = {}, .reflect = found.reflect, .transmit = found.transmit};
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const NetworkLayer &own = layers[k], &second = found.layers[k];
    SpongecakeFactors f{.roughness = second.roughness / own.roughness,
                        .depth = second.depth / own.depth};
    for (int c = 0; c < 3; ++c) {
      f.albedo[c] = second.albedo[c] / own.albedo[c];
      f.f0[c] = second.f0[c] / own.f0[c];
    }
    lobes.factors.push_back(f);
  }
  return lobes;
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
                    {"second", "the second single-scattering lobe", Order::multiple},
                    {"lambert", "the constant lobe", Order::multiple}},
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
                                 p.color(fmt::format("second_albedo_{}", k)),
                                 p.color(fmt::format("second_f0_{}", k))});
            const bool off = p.color("second_weight") == Rgb() &&
                             p.color("lambert_reflect") == Rgb() &&
                             p.color("lambert_transmit") == Rgb();
            if (p.choice("lobes") == "none" && !off)
              throw ParameterError("lobes", "\"none\" beside a lobe that is not 0",
                                   "auto, given, or no key of a lobe");
            const std::string& lobes = p.choice("lobes");
            const bool predicts =
                lobes == "network" || (lobes == "auto" && off && why_no_network(*stack).empty());
            if (predicts && off) {
              const SpongecakeLobes found = predicted_lobes(*stack);
              return std::make_unique<Spongecake>(*stack,
                                                  spongecake_second_stack(*stack, found.factors),
                                                  Rgb(1), found.reflect, found.transmit);
            }
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
