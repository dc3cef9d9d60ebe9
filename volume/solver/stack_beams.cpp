#include "volume/solver/stack_beams.h"

#include <cmath>

#include "volume/adding/smooth_boundary.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {
namespace {

// What the substrate mirrors of `mu`, as a number of that kind.
double one_more_event(double share, double /*kind*/) { return share; }
OrderShares one_more_event(double share, const OrderShares& /*kind*/) { return {{0, share}}; }

bool is_nothing(double share) { return share == 0; }
bool is_nothing(const OrderShares& shares) { return shares.sum() == 0; }

template <class Share>
StackBeamOf<Share> traced(const std::vector<StackElement>& elements, Direction w, bool reversed,
                          const MirroringGround& ground) {
  const std::size_t n = elements.size();
  const double top = n == 0 ? 1 : elements.front().above,
               bottom = n == 0 ? 1 : elements.back().below;
  const bool from_above = w.z > 0;
  StackBeamOf<Share> beam{std::vector<double>(n + 1), std::vector<Share>(n + 1),
                          std::vector<Share>(n + 1), std::vector<double>(n),
                          std::vector<double>(n)};
  for (std::size_t p = 0; p <= n; ++p)
    beam.mu[p] = snell_cosine(std::abs(w.z), from_above ? top : bottom,
                              p == 0 ? top : elements[p - 1].below);
  // Where light comes from, as media see it: interfaces keep the azimuth, and light that leaves
  // along w comes from the other side.
  const double across = std::hypot(w.x, w.y), sign = reversed ? -1 : 1;
  const double x = across > 0 ? sign * w.x / across : 1, y = across > 0 ? sign * w.y / across : 0;
  struct Crossing {
    double reflected, down, up;
  };
  std::vector<Crossing> crossings;
  for (std::size_t e = 0; e < n; ++e) {
    const double mu = beam.mu[e];
    if (const Layer* layer = elements[e].layer) {
      if (mu > 0) {
        const double sine = std::sqrt((1 - mu) * (1 + mu)), z = reversed ? -mu : mu;
        beam.rate_down[e] = sigma(layer->medium, {sine * x, sine * y, z}) / mu;
        beam.rate_up[e] = sigma(layer->medium, {sine * x, sine * y, -z}) / mu;
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
  std::vector<Share> beyond(n + 1);
  const auto step = [&](std::size_t e) {
    const std::size_t far = from_above ? e + 1 : e, near = from_above ? e : e + 1;
    const Crossing& c = crossings[e];
    const Share twice = c.down * c.up * beyond[far];
    beyond[near] =
        c.reflected + (is_nothing(twice) ? Share() : with_rounds(twice, c.reflected * beyond[far]));
  };
  if (from_above) beyond[n] = one_more_event(ground(beam.mu[n]), Share());
  if (from_above)
    for (std::size_t e = n; e-- > 0;) step(e);
  else
    for (std::size_t e = 0; e < n; ++e) step(e);
  std::vector<Share>& on = from_above ? beam.down : beam.up;
  std::vector<Share>& back = from_above ? beam.up : beam.down;
  on[from_above ? 0 : n] = 1.0 + Share();
  const auto follow = [&](std::size_t e) {
    const std::size_t far = from_above ? e + 1 : e, near = from_above ? e : e + 1;
    const Crossing& c = crossings[e];
    const double crosses = from_above ? c.down : c.up;
    on[far] = crosses == 0 ? Share() : with_rounds(crosses * on[near], c.reflected * beyond[far]);
  };
  if (from_above)
    for (std::size_t e = 0; e < n; ++e) follow(e);
  else
    for (std::size_t e = n; e-- > 0;) follow(e);
  for (std::size_t p = 0; p <= n; ++p) back[p] = beyond[p] * on[p];
  return beam;
}

}  // namespace

std::vector<StackElement> elements_of(const Stack& stack) {
  return elements_between(stack, 0, stack.layers.size());
}

std::vector<StackElement> elements_between(const Stack& stack, std::size_t begin, std::size_t end) {
  std::vector<StackElement> elements;
  double index = stack.index_of(begin);
  for (std::size_t k = begin; k < end; ++k) {
    const Layer& layer = stack.layers[k];
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

StackBeam beam_of(const std::vector<StackElement>& elements, Direction w, bool reversed,
                  const MirroringGround& ground) {
  return traced<double>(elements, w, reversed, ground);
}

StackBeamOf<OrderShares> beam_by_order(const std::vector<StackElement>& elements, Direction w,
                                       const MirroringGround& ground) {
  return traced<OrderShares>(elements, w, false, ground);
}

MirroringGround ground_of(const Stack& stack, int channel) {
  const SurfaceLaw* law = stack.substrate ? stack.substrate->law.get() : nullptr;
  if (!law || !law->is_delta()) return [](double) { return 0.0; };
  return [law, channel](double mu) {
    if (!(mu > 0)) return 0.0;
    RandomStream unused(0, 0, StreamPurpose::walk);
    const auto sample = law->sample({std::sqrt((1 - mu) * (1 + mu)), 0, mu}, unused);
    return sample ? sample->weight[channel] : 0.0;
  };
}

}  // namespace lamella
