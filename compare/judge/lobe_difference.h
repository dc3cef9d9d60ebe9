#pragma once

#include <vector>

#include "compare/judge/comparison.h"
#include "volume/run/simulation.h"

namespace lamella {

/// Two simulations of one incident direction on the same cells: the error on one lobe if the second
/// stack replaces the first.
struct LobeDifference {
  Direction wi{};
  bool reflected = true;
  int order = kTallyOrders;                              ///< slot of the tally, kTallyOrders: all
  std::vector<double> energy, energy_error;              ///< of the first, per channel
  std::vector<double> energy_other, energy_other_error;  ///< of the second
  /// Per channel, how much either energy may be too low, as walks were cut (missing_light.h).
  std::vector<double> energy_missing, energy_other_missing;
  /// Root mean square over cells and channels of the difference of f, with both noises' variance
  /// removed, over that of the first; 0 if the noise exceeds it; inf if only the second arrives.
  double relative_rmse_without_noise = 0;
  double p_value = 1;  ///< of the hypothesis that both are the same
  Verdict verdict = Verdict::agrees;
  double hidden = 0;  ///< squared relative RMSE that noise and missing light could hide
};

/// Every lobe of two simulations with the same cells, channels, walks and incident direction but
/// different seeds. The p-value is Hotelling's on a few patches of the hemisphere, from the 128
/// differences between batches; patches that few walks reach are pooled. Where walks were cut,
/// light that both may lack is no difference: the p-value is then that of the largest deviation,
/// beyond this light, of a patch or of the whole lobe.
[[nodiscard]] std::vector<LobeDifference> differences(const Simulation& first,
                                                      const Simulation& second);

/// Sets the verdicts, as `decide` does for closed forms: the probability that any lobe is called
/// different that is not is 1 %; insufficient if the noise could hide 10 %.
void decide(std::vector<LobeDifference>& lobes);

}  // namespace lamella
