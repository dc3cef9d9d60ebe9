#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "volume/run/simulation.h"

namespace lamella {

/// Some of the batches of a simulation as bytes: their sums, not means, so that walks which ran
/// apart are reduced as if they had run together.
struct SavedWalks {
  std::uint64_t walks = 0;  ///< of the whole simulation, in all of its batches
  double seconds = 0;       ///< that they took
  bool done = false;        ///< whether these batches have all of their walks
  std::vector<int> batches{};
};

/// The batches that walk in this simulation. Where they are not done, what walks on lanes need to
/// go on is saved with them.
[[nodiscard]] std::string save_walks(const Simulation& simulation, double seconds, bool done);

/// Puts saved batches into a simulation of the same stack, plan, direction, estimator, targets and
/// seed, beside those that are there. Throws DamagedBytes where they are none of this simulation's:
/// another estimator or number of targets, a batch that is there already (`there`, which the
/// batches are added to), sums that are not finite, or numbers of walks that do not fit.
SavedWalks restore_walks(std::string_view bytes, Simulation& simulation, std::vector<bool>& there);

}  // namespace lamella
