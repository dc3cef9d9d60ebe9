#include "analytic/layered/single_scattering_model.h"

#include <cmath>

namespace lamella {

Rgb SingleScatteringModel::eval_lobe(int lobe, Direction wi, Direction wo) const {
  const SingleScattering f = single_scattering(stack_, wi, wo);
  return lobe == 0 ? f.layers : f.substrate;
}

void SingleScatteringModel::eval_lobes(Direction wi, Direction wo, std::span<Rgb> values) const {
  const SingleScattering f = single_scattering(stack_, wi, wo);
  values[0] = f.layers;
  values[1] = f.substrate;
}

Rgb SingleScatteringModel::eval(Direction wi, Direction wo) const {
  const SingleScattering f = single_scattering(stack_, wi, wo);
  return f.layers + f.substrate;
}

std::vector<double> SingleScatteringModel::first_event(Direction wo) const {
  wo = with_grazing_limit(wo);
  const int n = static_cast<int>(stack_.layers.size());
  std::vector<double> probability(n + 1, 0.0);
  double passed = 1;
  for (int step = 0; step < n; ++step) {
    const int k = wo.z > 0 ? step : n - 1 - step;
    const Layer& layer = stack_.layers[k];
    const double x = optical_depth(layer.depth(), sigma(layer.medium, wo), std::abs(wo.z));
    if (!is_delta(layer.medium)) probability[k] = passed * -std::expm1(-x);
    passed *= std::exp(-x);
  }
  if (stack_.substrate && wo.z > 0) probability[n] = passed;
  return probability;
}

std::optional<Direction> SingleScatteringModel::sample(Direction wo, double u1, double u2,
                                                       double u3) const {
  const std::vector<double> probability = first_event(wo);
  double total = 0;
  for (const double p : probability) total += p;
  if (!(total > 0)) return std::nullopt;
  double rest = u1 * total;
  std::size_t chosen = 0;
  while (chosen + 1 < probability.size() && rest >= probability[chosen])
    rest -= probability[chosen++];
  while (probability[chosen] == 0) --chosen;
  if (chosen == stack_.layers.size()) return cosine_hemisphere(Direction{0, 0, 1}, u2, u3);
  // Phase functions take as many numbers as they need; a stream keyed by the uniforms keeps the
  // sampler a function of them.
  RandomStream stream(static_cast<std::uint64_t>(u2 * 0x1p53),
                      static_cast<std::uint64_t>(u3 * 0x1p53), StreamPurpose::model);
  return std::visit(
      [&](const auto& medium) { return medium.collide(wo, stream).sample(stream).wo; },
      stack_.layers[chosen].medium);
}

double SingleScatteringModel::pdf(Direction wi, Direction wo) const {
  const std::vector<double> probability = first_event(wo);
  double total = 0, density = 0;
  for (std::size_t k = 0; k < probability.size(); ++k) {
    total += probability[k];
    if (probability[k] == 0) continue;
    density += probability[k] * (k == stack_.layers.size()
                                     ? std::max(0.0, wi.z) / kPi
                                     : phase(stack_.layers[k].medium, wo, wi).density);
  }
  return total > 0 ? density / total : 0;
}

ModelInfo single_scattering_model() {
  return {.name = "single_scattering",
          .doc = "exact single scattering of any stack, reflection and transmission",
          .source = "Wang et al. 2022, SpongeCake, eqs. 8-16; Chandrasekhar 1960",
          .parameters = {},
          .lobes = {{"layers", "one event in one of the layers", Order::one},
                    {"substrate", "one reflection from the substrate", Order::one}},
          .reciprocal = true,
          .transmits = true,
          .needs_stack = true,
          .make =
              [](const Parameters&, const Stack* stack) {
                refuse_grid(*stack, "single_scattering");
                refuse_boundaries(*stack, "single_scattering");
                return std::make_unique<SingleScatteringModel>(*stack);
              },
          .applies_to =
              [](const Stack& stack) {
                return stack.has_grid() || stack.grains() || stack.has_boundaries()
                           ? std::nullopt
                           : std::optional(Parameters());
              }};
}

}  // namespace lamella
