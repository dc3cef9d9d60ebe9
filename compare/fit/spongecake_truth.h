#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "compare/fit/spongecake_fit.h"
#include "volume/plan/plan.h"
#include "volume/result/run_result.h"

namespace lamella {

/// The cells that lobes are fitted on.
inline constexpr CellGrid kFitGrid{8, 16, false};
/// The noise of the truth at which the walks of a fit end, as a share of the residual that the
/// lobes leave: the noise adds 3 % to that residual.
inline constexpr double kFitNoise = 0.25;

/// A fit and the truth that it was made to, at theta_i = 0, 30, 60, 80 degrees, phi_i = 0; of
/// stacks with a preferred azimuth at phi_i = 90 degrees, too.
struct SpongecakeTruth {
  std::vector<RunResult> runs;
  SpongecakeFit fit;
  std::uint64_t walks = 0;  ///< per direction, where they are fewest; 0: by the solver
  bool is_sharp = false;    ///< whether the noise is below kFitNoise of the residual
  bool is_late = false;     ///< whether the clock has ended it
};

/// The options of a fit.
struct SpongecakeEffort {
  std::uint64_t seed = 1;
  WalkLimits limits{};
  std::optional<Isa> isa{};                 ///< nothing: the widest of the machine
  const std::atomic<bool>* stop = nullptr;  ///< once set, the walks at hand are the last
};

/// fit_spongecake to the solver's answer where that applies, no limit of walks was asked for and
/// its bounds are below kFitNoise of the residual; else to walks.
[[nodiscard]] SpongecakeTruth fit_spongecake_to_truth(const Stack& stack,
                                                      const SpongecakeEffort& effort);

/// fit_spongecake to as many walks as the fit needs: from 1e5 per direction on, four times as many
/// in each step, until their noise is below kFitNoise of the residual, up to 6.4e6, or for 20 s.
/// Analog walks, of seed + 2^32, so that they differ from the walks of a comparison with a small
/// seed. Throws std::invalid_argument where there is nothing to fit.
[[nodiscard]] SpongecakeTruth fit_spongecake_by_walks(const Stack& stack,
                                                      const SpongecakeEffort& effort);

}  // namespace lamella
