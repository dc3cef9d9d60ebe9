#pragma once

#include <string>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/result/run_result.h"

namespace lamella {

/// How far a fit is from the multiple scattering of one incident direction and side.
struct SpongecakeResidue {
  Direction wi{};
  bool reflected = true;
  double energy_truth = 0, energy_model = 0;  ///< of orders 2 and up, luminance (Rec. 709)
  double relative_rmse = 0;                   ///< over the cells; 1: as far off as no lobe at all
  double noise = 0;  ///< the simulation's part of relative_rmse, with that of missing light
  /// How much energy_truth may be too low, as walks were cut: 3 standard errors included.
  double energy_missing = 0;
};

struct SpongecakeFit {
  std::string request;  ///< "spongecake,key=value,...", as --model takes it
  std::vector<SpongecakeResidue> residues;
  double relative_rmse = 0, noise = 0;  ///< over all directions and sides
  double walk_noise = 0;                ///< the part of `noise` that more walks would lessen
  int iterations = 0;
};

/// The best that SpongeCake's two further lobes can do on a stack: nonlinear least squares over the
/// cells of orders 2 and up, all runs and sides at once, cells being of equal projected solid
/// angle. Free are the second lobe's roughness and depth factors per layer, the albedo factors of
/// the layers after the first per channel, its weight, and the constant lobes. From two starts, the
/// better one. The stack must be SpongeCake's, of at most kSpongecakeLayers layers.
[[nodiscard]] SpongecakeFit fit_spongecake(const Stack& stack, const std::vector<RunResult>& runs);

}  // namespace lamella
