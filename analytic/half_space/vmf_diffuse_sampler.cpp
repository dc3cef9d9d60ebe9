#include "analytic/half_space/vmf_diffuse_sampler.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

constexpr int kNodes = 9;  // per dimension

// a, b, c, d, uniform
constexpr ClippedCosine kLobes[kNodes * kNodes] = {
#include "analytic/half_space/vmf_diffuse_sampler_table.h"
};

}  // namespace

ClippedCosine vmf_diffuse_sampling_lobe(double mu, double roughness) {
  const double x = std::sqrt(roughness) * (kNodes - 1);
  const double y = std::sqrt(std::clamp(mu, 0.0, 1.0)) * (kNodes - 1);
  const int i = std::min(static_cast<int>(x), kNodes - 2);
  const int j = std::min(static_cast<int>(y), kNodes - 2);
  const double u = x - i, v = y - j;
  const ClippedCosine* node = kLobes + i * kNodes + j;
  const auto mix = [&](double ClippedCosine::*m) {
    return (1 - u) * ((1 - v) * node[0].*m + v * node[1].*m) +
           u * ((1 - v) * node[kNodes].*m + v * node[kNodes + 1].*m);
  };
  return {.a = mix(&ClippedCosine::a),
          .b = mix(&ClippedCosine::b),
          .c = mix(&ClippedCosine::c),
          .d = mix(&ClippedCosine::d),
          .uniform = mix(&ClippedCosine::uniform)};
}

}  // namespace lamella
