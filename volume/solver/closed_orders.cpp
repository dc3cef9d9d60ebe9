#include "volume/solver/closed_orders.h"

#include <cmath>
#include <vector>

#include "phase/interface/dielectric.h"
#include "phase/stack/single_scattering.h"
#include "volume/adding/smooth_boundary.h"
#include "volume/quadrature/depth_integrals.h"

namespace lamella {
namespace {

// From the top: a layer, or a boundary where there is none.
struct Element {
  const Layer* layer;
  const Interface* interface;
  double above, below;  // indices of refraction

  [[nodiscard]] bool is_rough() const {
    return interface && interface->facets.shape != FacetShape::smooth;
  }
};

std::vector<Element> elements_of(const Stack& stack) {
  std::vector<Element> elements;
  double index = 1;
  for (const Layer& layer : stack.layers) {
    if (layer.interface) {
      if (layer.interface->ior != index)
        elements.push_back({nullptr, &*layer.interface, index, layer.interface->ior});
      index = layer.interface->ior;
    } else if (layer.depth() > 0) {
      elements.push_back({&layer, nullptr, index, index});
    }
  }
  return elements;
}

// A beam's shares at the places between elements: before the first, ... after the last.
struct Beam {
  std::vector<double> mu;                  // by place; 0: totally reflected before
  std::vector<double> down, up;            // shares of what arrives
  std::vector<double> rate_down, rate_up;  // by element: optical depth per depth
};

// reversed: light that leaves along w, run backwards. ground(mu): what the substrate mirrors.
template <class Ground>
Beam beam_of(const std::vector<Element>& elements, Direction w, bool reversed,
             const Ground& ground) {
  const std::size_t n = elements.size();
  const double top = n == 0 ? 1 : elements.front().above,
               bottom = n == 0 ? 1 : elements.back().below;
  const bool from_above = w.z > 0;
  Beam beam{std::vector<double>(n + 1), std::vector<double>(n + 1, 0.0),
            std::vector<double>(n + 1, 0.0), std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t p = 0; p <= n; ++p)
    beam.mu[p] = snell_cosine(std::abs(w.z), from_above ? top : bottom,
                              p == 0 ? top : elements[p - 1].below);
  struct Crossing {
    double reflected, down, up;
  };
  std::vector<Crossing> crossings;
  for (std::size_t e = 0; e < n; ++e) {
    const double mu = beam.mu[e];
    if (const Layer* layer = elements[e].layer) {
      if (mu > 0) {
        const double sine = std::sqrt((1 - mu) * (1 + mu)), z = reversed ? -mu : mu;
        beam.rate_down[e] = sigma(layer->medium, {sine, 0, z}) / mu;
        beam.rate_up[e] = sigma(layer->medium, {sine, 0, -z}) / mu;
      }
      const auto crosses = [&](double rate) {
        return mu > 0 && rate > 0 ? std::exp(-rate * layer->depth()) : mu > 0 ? 1.0 : 0.0;
      };
      crossings.push_back({0, crosses(beam.rate_down[e]), crosses(beam.rate_up[e])});
    } else if (elements[e].is_rough()) {
      crossings.push_back({0, 0, 0});  // beams end here
    } else {
      const SmoothShares s =
          smooth_shares(elements[e].above, mu, elements[e].below, beam.mu[e + 1]);
      crossings.push_back({s.reflected, s.transmitted, s.transmitted});
    }
  }
  // What lies beyond each place, as seen by the beam, reflects that share.
  std::vector<double> beyond(n + 1, 0.0);
  const auto step = [&](std::size_t e) {
    const std::size_t far = from_above ? e + 1 : e, near = from_above ? e : e + 1;
    const Crossing& c = crossings[e];
    const double twice = c.down * c.up * beyond[far];
    beyond[near] = c.reflected + (twice == 0 ? 0 : twice / (1 - c.reflected * beyond[far]));
  };
  if (from_above) beyond[n] = ground(beam.mu[n]);
  if (from_above)
    for (std::size_t e = n; e-- > 0;) step(e);
  else
    for (std::size_t e = 0; e < n; ++e) step(e);
  std::vector<double>& on = from_above ? beam.down : beam.up;
  std::vector<double>& back = from_above ? beam.up : beam.down;
  on[from_above ? 0 : n] = 1;
  const auto follow = [&](std::size_t e) {
    const std::size_t far = from_above ? e + 1 : e, near = from_above ? e : e + 1;
    const Crossing& c = crossings[e];
    const double crosses = from_above ? c.down : c.up;
    on[far] = crosses == 0 ? 0 : on[near] * crosses / (1 - c.reflected * beyond[far]);
  };
  if (from_above)
    for (std::size_t e = 0; e < n; ++e) follow(e);
  else
    for (std::size_t e = n; e-- > 0;) follow(e);
  for (std::size_t p = 0; p <= n; ++p) back[p] = beyond[p] * on[p];
  return beam;
}

Beam beam_of(const std::vector<Element>& elements, Direction w, bool reversed) {
  return beam_of(elements, w, reversed, [](double) { return 0.0; });
}

// w within a medium: refracted, going up or down.
Direction inside(Direction w, double from, double to, double z) {
  const double scale = from / to;
  return renormalized(Direction{scale * w.x, scale * w.y, z});
}

Rgb first_through_smooth(const Stack& stack, Direction wi, Direction wo) {
  const std::vector<Element> elements = elements_of(stack);
  const double top = 1, bottom = elements.empty() ? 1 : elements.back().below;
  const double from = wi.z > 0 ? top : bottom, to = wo.z > 0 ? top : bottom;
  const Beam in = beam_of(elements, wi, false), out = beam_of(elements, wo, true);
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
      const Direction i = inside(wi, from, index, arrives_down ? mi : -mi);
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
        const PhaseValue p = phase(layer->medium, i, inside(wo, to, index, leaves_up ? mo : -mo));
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
      sum += share * law->eval(inside(wi, 1, bottom, mi), inside(wo, 1, bottom, mo), unused);
  } else {
    sum += lambert_radiance(share) * stack.substrate->albedo;
  }
  return sum;
}

// One event at a rough boundary between beams; those that another one hides are none.
double zero_at_rough(const Stack& stack, Direction wi, Direction wo) {
  const std::vector<Element> elements = elements_of(stack);
  const double top = 1, bottom = elements.back().below;
  const double from = wi.z > 0 ? top : bottom, to = wo.z > 0 ? top : bottom;
  const Beam in = beam_of(elements, wi, false), out = beam_of(elements, wo, true);
  double sum = 0;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const Element& at = elements[e];
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
               boundary.single(inside(wi, from, n_in, arrives_down ? mi : -mi),
                               inside(wo, to, n_out, leaves_up ? mo : -mo));
      }
  }
  return sum;
}

}  // namespace

Rgb mirrored_share(const Stack& stack, Direction wi) {
  if (!stack.has_boundaries()) return {};
  wi = with_grazing_limit(wi);
  const std::vector<Element> elements = elements_of(stack);
  const SurfaceLaw* law = stack.substrate ? stack.substrate->law.get() : nullptr;
  if (law && !law->is_delta()) law = nullptr;
  Rgb share;
  for (int c = 0; c < 3; ++c) {
    const auto ground = [&](double mu) {
      if (!law || !(mu > 0)) return 0.0;
      RandomStream unused(0, 0, StreamPurpose::walk);
      const auto sample = law->sample({std::sqrt((1 - mu) * (1 + mu)), 0, mu}, unused);
      return sample ? sample->weight[c] : 0.0;
    };
    share[c] = beam_of(elements, wi, false, ground).up.front();
  }
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
