#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "volume/harmonics/harmonic_scope.h"
#include "volume/harmonics/harmonic_transport.h"
#include "volume/harmonics/layer_blocks.h"

namespace lamella {

/// Degrees that are tried one after the other; each solution is the bound of the one before.
inline constexpr int kHarmonicDegrees[] = {12, 17, 24, 34, 48, 68, 96, 136, 192};

/// Narrow distributions change nothing at low degrees: the first one that is worth its time. Where
/// boundaries couple all waves, high degrees take long.
[[nodiscard]] inline std::size_t first_degree(const Stack& stack) {
  if (has_anisotropic_boundaries(stack)) return 0;
  const double width = narrowest_feature(stack);
  return width > 0.4 ? 0 : width > 0.2 ? 1 : width > 0.08 ? 2 : 3;
}

/// The time of the next degree over that of degree k: about this power of their ratio.
[[nodiscard]] inline double growth(std::size_t k) {
  constexpr double kPower = 3.4;
  return std::pow(static_cast<double>(kHarmonicDegrees[k + 1]) / kHarmonicDegrees[k], kPower);
}

/// The memory of boundaries' operators at the next degree over that at degree k: nodes and waves of
/// both sides, where boundaries couple them.
[[nodiscard]] inline double growth_of_operators(std::size_t k) { return growth(k); }

/// Bytes that a solution without boundaries holds, of the channel that takes most.
[[nodiscard]] inline std::size_t bytes_of_open(const Stack& stack, const std::vector<int>& channels,
                                               const HarmonicResolution& resolution) {
  std::size_t most = 0;
  for (const int channel : channels)
    most = std::max(most, HarmonicTransport::bytes(stack, channel, resolution));
  return most;
}

/// Light that grazes more than this is solved as if it did not.
[[nodiscard]] inline Direction solvable(Direction wi) {
  constexpr double kLowest = 1e-6;
  wi = with_grazing_limit(wi);
  if (std::abs(wi.z) < kLowest)
    wi = direction_from_mu_phi(std::copysign(kLowest, wi.z), azimuth(wi));
  return wi;
}

/// levels: solutions before this one. lowest: the least |mu_i|.
[[nodiscard]] inline HarmonicResolution resolution_of(int degree, int levels, double lowest,
                                                      double tolerance, Isa isa,
                                                      const std::atomic<bool>* stop) {
  return {.degree = degree,
          .depth_nodes = std::min(8, 5 + levels),
          .finest = std::min(tolerance < 1e-6 ? 1e-3 : 4e-3, lowest / 4),
          .residual = std::clamp(tolerance / 100, 1e-12, 1e-8),
          .isa = isa,
          .stop = stop};
}

}  // namespace lamella
