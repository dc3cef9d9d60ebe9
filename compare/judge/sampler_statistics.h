#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// Statistics of a sampler at one w_o: of the weight f |mu_i| / pdf, of which the largest channel
/// counts.
struct SamplerStatistics {
  double mean = 0, mean_error = 0;  ///< estimates the directional albedo
  double variance = 0;
  double max_weight = 0;
  double lost = 0;  ///< share of samples without a direction, or with weight 0
};

/// From `samples` draws. Throws std::domain_error at a weight that is not finite.
[[nodiscard]] SamplerStatistics sampler_statistics(const Model& model, Direction wo,
                                                   std::uint64_t samples, std::uint64_t seed);

/// Nanoseconds of the calling thread, the least of several repetitions.
struct SamplerTimes {
  double eval = 0;    ///< one evaluation at random directions
  double sample = 0;  ///< one draw from a random w_o, its density, and the evaluation there
};
[[nodiscard]] SamplerTimes sampler_times(const Model& model, double seconds);

}  // namespace lamella
