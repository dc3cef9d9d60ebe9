#include "analytic/spongecake.h"

#include <algorithm>

#include "analytic/single_scattering.h"

namespace lamella {

bool is_spongecake_stack(const Stack& stack) {
  return std::all_of(stack.layers.begin(), stack.layers.end(), [](const Layer& layer) {
    return std::holds_alternative<MirrorFlakes<Sggx>>(layer.medium) ||
           std::holds_alternative<HenyeyGreenstein>(layer.medium);
  });
}

ModelInfo spongecake_model() {
  return {.name = "spongecake",
          .doc = "single scattering of SGGX mirror flakes and Henyey-Greenstein layers",
          .source = "Wang et al. 2022, SpongeCake, section 4",
          .parameters = {},
          .lobes = {{"single", "one event in one of the layers", Order::one},
                    {"substrate", "one reflection from the substrate", Order::one}},
          .reciprocal = true,
          .transmits = true,
          .needs_stack = true,
          .make = [](const Parameters&, const Stack* stack) -> std::unique_ptr<Model> {
            if (!is_spongecake_stack(*stack))
              throw ParameterError("stack", stack->name,
                                   "a stack of SGGX mirror flakes and Henyey-Greenstein layers");
            return std::make_unique<SingleScatteringModel>(*stack);
          },
          .applies_to =
              [](const Stack& stack) {
                return is_spongecake_stack(stack) ? std::optional(Parameters()) : std::nullopt;
              }};
}

}  // namespace lamella
