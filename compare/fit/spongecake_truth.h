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
/// The noise of the truth that a fit is content with, as a share of what the lobes leave over: it
/// adds 3 % to it.
inline constexpr double kFitNoise = 0.25;

/// A fit and the truth that it was made to, at theta_i = 0, 30, 60, 80 degrees.
struct SpongecakeTruth {
  std::vector<RunResult> runs;
  SpongecakeFit fit;
  std::uint64_t walks = 0;  ///< per direction, where they are fewest
  bool is_sharp = false;    ///< whether the noise is below kFitNoise of what the lobes leave over
  bool is_late = false;     ///< whether the clock has ended it
};

/// What a fit may be asked for.
struct SpongecakeEffort {
  std::uint64_t seed = 1;
  WalkLimits limits{};
  std::optional<Isa> isa{};                 ///< nothing: the widest of the machine
  const std::atomic<bool>* stop = nullptr;  ///< once set, the walks at hand are the last
};

/// fit_spongecake to walks, as many as it needs: from 1e5 per direction fourfold, until their noise
/// is below kFitNoise of what the lobes leave over, up to 6.4e6, or for 20 s. Analog walks, of seed
/// + 2^32, so that those of a comparison with a small seed are others. Throws std::invalid_argument
/// where there is nothing to fit.
[[nodiscard]] SpongecakeTruth fit_spongecake_by_walks(const Stack& stack,
                                                      const SpongecakeEffort& effort);

}  // namespace lamella
