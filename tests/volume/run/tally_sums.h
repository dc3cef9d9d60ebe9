#pragma once

#include <vector>

#include "volume/run/simulation.h"

namespace lamella::testing {

/// Sums of all batches as one list, to compare runs bit by bit: f, energies upwards by order,
/// absorbed.
inline std::vector<double> tally_sums(const Simulation& simulation) {
  std::vector<double> sums;
  for (const BatchTally& b : simulation.batches()) {
    sums.insert(sums.end(), b.f.begin(), b.f.end());
    for (const auto& order : b.energy.up) sums.insert(sums.end(), order.begin(), order.end());
    sums.insert(sums.end(), b.energy.absorbed.begin(), b.energy.absorbed.end());
  }
  return sums;
}

}  // namespace lamella::testing
