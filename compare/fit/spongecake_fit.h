#pragma once

#include <string>
#include <vector>

#include "compare/fit/two_lobe_fit.h"
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
  SpongecakeLobes lobes;
  std::string request;  ///< "spongecake,key=value,...", as --model takes it
  std::vector<SpongecakeResidue> residues;
  double relative_rmse = 0, noise = 0;  ///< over all directions and sides
  double walk_noise = 0;                ///< the part of `noise` that more walks would lessen
  int iterations = 0;
};

/// The lobes as --model takes them: "spongecake,key=value,...".
[[nodiscard]] std::string lobes_request(const Stack& stack, const SpongecakeLobes& lobes);

/// The best that SpongeCake's two further lobes can do on a stack (fit_two_lobes): over the cells
/// of orders 2 and up, all runs, sides and channels at once. The stack must be SpongeCake's.
[[nodiscard]] SpongecakeFit fit_spongecake(const Stack& stack, const std::vector<RunResult>& runs);

}  // namespace lamella
