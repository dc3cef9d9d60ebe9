#include "volume/solver/distinct_channels.h"

#include <algorithm>

#include "phase/math/direction.h"

namespace lamella {
namespace {

// Whether a law reflects two channels the same, as far as some directions tell.
bool channels_equal(const SurfaceLaw& law, int a, int b) {
  RandomStream unused(0, 0, StreamPurpose::walk);
  for (const double mu : {1.0, 0.9, 0.6, 0.3, 0.05}) {
    const Direction wi = direction_from_mu_phi(mu, 0);
    if (law.is_delta()) {
      const auto sample = law.sample(wi, unused);
      if (sample && sample->weight[a] != sample->weight[b]) return false;
      continue;
    }
    for (const double phi : {0.0, 1.0, 2.0, kPi}) {
      const Rgb f = law.eval(wi, direction_from_mu_phi(0.7 * mu + 0.1, phi), unused);
      if (f[a] != f[b]) return false;
    }
  }
  return true;
}

bool channels_equal(const Stack& stack, int a, int b) {
  if (stack.substrate && stack.substrate->law && !channels_equal(*stack.substrate->law, a, b))
    return false;
  return std::all_of(
             stack.layers.begin(), stack.layers.end(),
             [&](const Layer& l) { return l.albedo[a] == l.albedo[b] && l.f0[a] == l.f0[b]; }) &&
         (!stack.substrate || stack.substrate->albedo[a] == stack.substrate->albedo[b]);
}

}  // namespace

DistinctChannels distinct_channels(const Stack& stack) {
  DistinctChannels distinct;
  for (int c = 0; c < 3; ++c) {
    int same = 0;
    while (!channels_equal(stack, same, c)) ++same;
    if (same == c) distinct.channels.push_back(c);
    distinct.channel_of[c] =
        static_cast<int>(std::find(distinct.channels.begin(), distinct.channels.end(), same) -
                         distinct.channels.begin());
  }
  return distinct;
}

}  // namespace lamella
