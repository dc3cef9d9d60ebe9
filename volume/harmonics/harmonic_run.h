#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volume/harmonics/harmonic_scope.h"
#include "volume/plan/plan.h"
#include "volume/result/run_result.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// Where the refinement of a solution in spherical harmonics ends.
struct HarmonicOptions {
  double tolerance = 1e-4;  ///< of a cell, relative to the mean over its row
  double max_seconds = 60;  ///< a finer solution is not begun where it would end later
  int max_degree = 192;
  /// Of the operators of boundaries; without boundaries of kernels, rays and sources. A finer
  /// solution is not begun where it would take more.
  std::size_t max_bytes = std::size_t{2} << 30;
  /// Where a run is repeated: DeterministicAccuracy::integrated_from, whatever the clock says.
  std::optional<int> integrate_from{};
  Isa isa = Isa::scalar;  ///< of products of matrices, whose last digits depend on it
  const std::atomic<bool>* stop = nullptr;  ///< once set, what was reached is the answer
  SolverReport report{};
};

/// Cells and ledger of a stack of homogeneous layers of any orientation, one entry per incident
/// direction. The degree of the harmonics rises until no cell changes by more than the tolerance;
/// each value's bound is its last change and what its quadrature leaves. Order 1 is exact.
/// The derivation is in volume/HARMONICS.md. Throws std::invalid_argument where why_not_harmonic
/// tells why.
[[nodiscard]] std::vector<RunResult> harmonic_runs(const Stack& stack, const Plan& plan,
                                                   std::span<const Direction> incident,
                                                   CellGrid grid, const HarmonicOptions& options);

}  // namespace lamella
