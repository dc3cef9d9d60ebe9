#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "analytic/model/clipped_cosine.h"
#include "analytic/model/model.h"

namespace lamella {

/// Sampling lobes on a grid: for roughness r and cosine mu of w_o at uniform steps of sqrt(r) and
/// sqrt(mu), which are finer where lobes change most.
struct SamplingLobeTable {
  int roughnesses = 0, cosines = 0;
  std::vector<ClippedCosine> lobes{};  ///< [roughness][cosine]
  /// Second moment of the weight f |mu_i| / pdf at the nodes, before (cosine law) and after.
  std::vector<double> cosine_moment{}, moment{};
};

/// Fits the clipped cosine and its share of the uniform hemisphere (at least 0.02, so that no
/// weight is unbounded) to an isotropic model, by least squares: the squares are the second moment
/// of the weight, integral of (f |mu_i|)^2 / pdf, on a Gauss rule over the hemisphere of w_i. At
/// roughness 0 the lobe is the cosine's. `model`: the model at a roughness.
[[nodiscard]] SamplingLobeTable fit_sampling_lobes(
    const std::function<std::unique_ptr<Model>(double roughness)>& model, int roughnesses,
    int cosines);

/// The table as initializers of C++, one lobe a line.
[[nodiscard]] std::string to_initializers(const SamplingLobeTable& table);

}  // namespace lamella
