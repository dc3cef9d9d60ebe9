#include "analytic/single_scattering.h"

#include <cmath>

namespace lamella {
namespace {

// (1 - exp(-x)) / x
double mean_decay(double x) { return x == 0 ? 1 : -std::expm1(-x) / x; }

// Optical depth of a layer along a direction with projected area s and |cosine| m; 0 for an empty
// layer even where the cosine is at its limit.
double optical_depth(double depth, double s, double m) {
  return s == 0 || depth == 0 ? 0 : depth * s / m;
}

}  // namespace

SingleScattering single_scattering(const Stack& stack, Direction wi, Direction wo) {
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const bool reflects = (wi.z < 0) == (wo.z < 0);
  const bool from_above = wi.z > 0;
  const double mi = std::abs(wi.z), mo = std::abs(wo.z);
  SingleScattering result;
  if (!reflects && !stack.is_open_below()) return result;

  const int n = static_cast<int>(stack.layers.size());
  std::vector<double> areas_i(n), areas_o(n);
  for (int k = 0; k < n; ++k) {
    areas_i[k] = sigma(stack.layers[k].medium, wi);
    areas_o[k] = sigma(stack.layers[k].medium, -wo);
  }
  // Of the layers that transmitted light has yet to cross after each step. Summed from the far
  // side: a difference of sums would lose what is thin beside what is thick or grazing.
  std::vector<double> tau_o_far(n, 0.0);
  if (!reflects)
    for (int step = n - 1; step > 0; --step) {
      const int k = from_above ? step : n - 1 - step;
      tau_o_far[step - 1] =
          tau_o_far[step] + optical_depth(stack.layers[k].depth(), areas_o[k], mo);
    }
  double tau_i = 0, tau_o = 0;
  for (int step = 0; step < n; ++step) {
    const int k = from_above ? step : n - 1 - step;
    const Layer& layer = stack.layers[k];
    const double depth = layer.depth();
    const double si = areas_i[k], so = areas_o[k];
    const double xi = optical_depth(depth, si, mi), xo = optical_depth(depth, so, mo);
    const double outside = tau_i + (reflects ? tau_o : tau_o_far[step]);
    if (si > 0 && depth > 0 && outside < 800) {
      // Integral over the layer's depth of exp(-tau_i - tau_o), times sigma_i / (mu_i mu_o).
      double transport = 0;
      if (reflects) {
        const double x = xi + xo;
        // Thick: the depth cancels; thin: no difference of nearly equal numbers is taken.
        transport = x < 1 ? depth * si / (mi * mo) * mean_decay(x)
                          : si * -std::expm1(-x) / (si * mo + so * mi);
      } else {
        const double x = std::abs(xi - xo);
        transport = std::exp(-std::min(xi, xo)) *
                    (x < 1 ? depth * si / (mi * mo) * mean_decay(x)
                           : si * -std::expm1(-x) / std::abs(si * mo - so * mi));
      }
      if (transport > 0) {
        const PhaseValue p = phase(layer.medium, wi, wo);
        result.layers += transport * std::exp(-outside) * p.density *
                         (layer.albedo * schlick(layer.f0, p.schlick));
      }
    }
    tau_i += xi;
    tau_o += xo;
  }
  if (stack.substrate && reflects && from_above)
    result.substrate = std::exp(-tau_i - tau_o) / kPi * stack.substrate->albedo;
  return result;
}

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
  return {
      .name = "single_scattering",
      .doc = "exact single scattering of any stack, reflection and transmission",
      .source = "Wang et al. 2022, SpongeCake, eqs. 8-16; Chandrasekhar 1960",
      .parameters = {},
      .lobes = {{"layers", "one event in one of the layers", Order::one},
                {"substrate", "one reflection from the substrate", Order::one}},
      .reciprocal = true,
      .transmits = true,
      .needs_stack = true,
      .make = [](const Parameters&,
                 const Stack* stack) { return std::make_unique<SingleScatteringModel>(*stack); },
      .applies_to = [](const Stack&) { return std::optional(Parameters()); }};
}

}  // namespace lamella
