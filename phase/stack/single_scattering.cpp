#include "phase/stack/single_scattering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace lamella {
namespace {

// (1 - exp(-x)) / x
double mean_decay(double x) { return x == 0 ? 1 : -std::expm1(-x) / x; }

// A number per layer, without an allocation for few.
class PerLayer {
 public:
  explicit PerLayer(int layers) {
    if (layers <= kFew) return;
    many_.resize(layers);
    data_ = many_.data();
  }
  PerLayer(const PerLayer&) = delete;
  PerLayer& operator=(const PerLayer&) = delete;
  double& operator[](int k) { return data_[k]; }

 private:
  static constexpr int kFew = 8;
  std::array<double, kFew> few_{};
  std::vector<double> many_;
  double* data_ = few_.data();
};

// take(k, t): layer k has the light t p albedo (f0 + (1 - f0) s), p and s the density and the
// Schlick weight of its phase function. Returns what passes all layers twice.
// mu of w_i and w_o: not 0.
template <class Take>
double visit_layers(const Stack& stack, Direction wi, Direction wo, const Take& take) {
  if (stack.has_grid()) refuse_grid(stack, "single scattering in closed form");
  stack.require_layers("single scattering");
  const bool reflects = (wi.z < 0) == (wo.z < 0);
  const bool from_above = wi.z > 0;
  const double mi = std::abs(wi.z), mo = std::abs(wo.z);
  if (!reflects && !stack.is_open_below()) return 0;

  const int n = static_cast<int>(stack.layers.size());
  PerLayer areas_i(n), areas_o(n);
  for (int k = 0; k < n; ++k) {
    areas_i[k] = sigma(stack.layers[k].medium, wi);
    areas_o[k] = sigma(stack.layers[k].medium, -wo);
  }
  // Of the layers that transmitted light has yet to cross after each step. Summed from the far
  // side: a difference of sums would lose what is thin beside what is thick or grazing.
  PerLayer tau_o_far(n);
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
      if (transport > 0) take(k, transport * std::exp(-outside));
    }
    tau_i += xi;
    tau_o += xo;
  }
  return reflects && from_above ? std::exp(-tau_i - tau_o) : 0;
}

}  // namespace

SingleScattering single_scattering(const Stack& stack, Direction wi, Direction wo) {
  SingleScattering result;
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const double twice = visit_layers(stack, wi, wo, [&](int k, double transport) {
    const Layer& layer = stack.layers[k];
    const PhaseValue p = phase(layer.medium, wi, wo);
    result.layers += transport * p.density * (layer.albedo * schlick(layer.f0, p.schlick));
  });
  if (stack.substrate && twice > 0)
    result.substrate = lambert_radiance(twice) * stack.substrate->albedo;
  return result;
}

void single_scattering_by_layer(const Stack& stack, Direction wi, Direction wo,
                                std::span<LayerSingle> layers) {
  std::fill(layers.begin(), layers.end(), LayerSingle{});
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  visit_layers(stack, wi, wo, [&](int k, double transport) {
    const PhaseValue p = phase(stack.layers[k].medium, wi, wo);
    const double g = transport * p.density;
    layers[k] = {g, g * p.schlick};
  });
}

double single_scattering_transport(const Stack& stack, Direction wi, Direction wo,
                                   std::span<double> layers) {
  std::fill(layers.begin(), layers.end(), 0.0);
  return visit_layers(stack, with_grazing_limit(wi), with_grazing_limit(wo),
                      [&](int k, double transport) { layers[k] = transport; });
}

}  // namespace lamella
