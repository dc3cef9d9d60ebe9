#include "volume/solver/closed_orders.h"

#include <cmath>
#include <vector>

#include "phase/interface/dielectric.h"
#include "phase/stack/single_scattering.h"
#include "volume/quadrature/depth_integrals.h"
#include "volume/solver/stack_beams.h"

namespace lamella {
namespace {

Rgb first_through_smooth(const Stack& stack, Direction wi, Direction wo) {
  const std::vector<StackElement> elements = elements_of(stack);
  const double top = 1, bottom = elements.empty() ? 1 : elements.back().below;
  const double from = wi.z > 0 ? top : bottom, to = wo.z > 0 ? top : bottom;
  const StackBeam in = beam_of(elements, wi, false), out = beam_of(elements, wo, true);
  Rgb sum;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const Layer* layer = elements[e].layer;
    if (!layer) continue;
    const double mi = in.mu[e], mo = out.mu[e], index = elements[e].above;
    if (mi == 0 || mo == 0) continue;
    const double radiance = (to / index) * (to / index) / (mi * mo), depth = layer->depth();
    for (const bool arrives_down : {true, false}) {
      const double arrives = arrives_down ? in.down[e] : in.up[e + 1];
      const double rate_in = arrives_down ? in.rate_down[e] : in.rate_up[e];
      if (!(arrives > 0)) continue;
      const Direction i = refracted_to(wi, from, index, arrives_down ? mi : -mi);
      const double area = sigma(layer->medium, i);
      if (!(area > 0)) continue;
      for (const bool leaves_up : {true, false}) {
        const double leaves = leaves_up ? out.down[e] : out.up[e + 1];
        const double rate_out = leaves_up ? out.rate_down[e] : out.rate_up[e];
        if (!(leaves > 0)) continue;
        const double depths = arrives_down == leaves_up
                                  ? decay_integral(rate_in + rate_out, depth)
                                  : crossing_integral(rate_in, rate_out, depth);
        const double transport = arrives * leaves * radiance * area * depths;
        if (!(transport > 0)) continue;
        const PhaseValue p =
            phase(layer->medium, i, refracted_to(wo, to, index, leaves_up ? mo : -mo));
        sum += transport * p.density * (layer->albedo * schlick(layer->f0, p.schlick));
      }
    }
  }
  if (!stack.substrate || wi.z < 0 || wo.z < 0) return sum;
  const double mi = in.mu.back(), mo = out.mu.back();
  const double share = in.down.back() * out.down.back() / (bottom * bottom);
  if (!(share > 0)) return sum;
  if (const auto& law = stack.substrate->law) {
    RandomStream unused(0, 0, StreamPurpose::walk);
    if (!law->is_delta())
      sum += share *
             law->eval(refracted_to(wi, 1, bottom, mi), refracted_to(wo, 1, bottom, mo), unused);
  } else {
    sum += lambert_radiance(share) * stack.substrate->albedo;
  }
  return sum;
}

// One event at a rough boundary between beams; those that another one hides are none.
double zero_at_rough(const Stack& stack, Direction wi, Direction wo) {
  const std::vector<StackElement> elements = elements_of(stack);
  const double top = 1, bottom = elements.back().below;
  const double from = wi.z > 0 ? top : bottom, to = wo.z > 0 ? top : bottom;
  const StackBeam in = beam_of(elements, wi, false), out = beam_of(elements, wo, true);
  double sum = 0;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const StackElement& at = elements[e];
    if (!at.is_rough()) continue;
    const Dielectric boundary{.facets = at.interface->facets,
                              .masking = at.interface->masking,
                              .multiple = false,
                              .above = at.above,
                              .below = at.below};
    for (const bool arrives_down : {true, false})
      for (const bool leaves_up : {true, false}) {
        const std::size_t place_in = arrives_down ? e : e + 1, place_out = leaves_up ? e : e + 1;
        const double share =
            (arrives_down ? in.down : in.up)[place_in] * (leaves_up ? out.down : out.up)[place_out];
        if (!(share > 0)) continue;
        const double n_in = arrives_down ? at.above : at.below;
        const double n_out = leaves_up ? at.above : at.below;
        const double mi = in.mu[place_in], mo = out.mu[place_out];
        sum += share * (to / n_out) * (to / n_out) *
               boundary.single(refracted_to(wi, from, n_in, arrives_down ? mi : -mi),
                               refracted_to(wo, to, n_out, leaves_up ? mo : -mo));
      }
  }
  return sum;
}

}  // namespace

Rgb mirrored_share(const Stack& stack, Direction wi) {
  if (!stack.has_boundaries()) return {};
  wi = with_grazing_limit(wi);
  const std::vector<StackElement> elements = elements_of(stack);
  Rgb share;
  for (int c = 0; c < 3; ++c)
    share[c] = beam_of(elements, wi, false, ground_of(stack, c)).up.front();
  return share;
}

bool is_first_closed(const Stack& stack) { return !stack.has_rough_interfaces(); }

ClosedOrders closed_orders(const Stack& stack, Direction wi, Direction wo) {
  if (!stack.has_boundaries()) {
    const SingleScattering single = single_scattering(stack, wi, wo);
    return {{}, single.layers + single.substrate};
  }
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  if ((wi.z < 0 || wo.z < 0) && !stack.is_open_below()) return {};
  if (is_first_closed(stack)) return {{}, first_through_smooth(stack, wi, wo)};
  return {Rgb(zero_at_rough(stack, wi, wo)), {}};
}

}  // namespace lamella
