#pragma once

#include <cstdint>
#include <functional>

#include "compare/judge/check_line.h"
#include "compare/judge/checked_model.h"

namespace lamella {

/// What a sampler is checked with.
struct SamplerCheckSettings {
  std::uint64_t samples = 20000;  ///< per direction
  std::uint64_t seed = 1;
  double level = 1e-6;  ///< probability with which one true case may fail by chance
  double seconds = 2;   ///< that one quadrature may take
  std::function<bool()> stop{};
};

/// The largest weights f |mu_i| / pdf that were met, and the largest variance.
struct SamplerExtremes {
  double variance = 0, max_weight = 0, lost = 0;
  double theta_o = 0;        ///< degrees, where the variance is largest
  std::string parameters{};  ///< and of which model
};

struct SamplerLines {
  CheckLine density, samples, weights, albedo;
  SamplerExtremes extremes{};
};

/// Checks the sampler at one w_o:
/// - density: the integral of pdf over w_i is 1 less the share of draws without a direction.
/// - samples: the counts of draws in cells of equal shares against the integrals of pdf over them,
///   by chi-square.
/// - weights: their mean is the integral of f |mu_i| over w_i. Allowed: Bernstein's bound with the
///   variance by quadrature and the largest weight at any node or draw, so that a sampler that
///   seldom meets a peak is no failure; undecided where the bound is above a tenth of the mean.
/// - albedo: where the model is reciprocal, grey and reflects alone, that integral is the
///   directional albedo.
/// Quadratures' errors are allowed besides, and 1e-6.
void check_sampler(const CheckedModel& m, Direction wo, const SamplerCheckSettings& settings,
                   SamplerLines& lines);

}  // namespace lamella
