#pragma once

#include <optional>
#include <string>

#include "phase/stack/stack.h"
#include "volume/result/run_result.h"

namespace lamella {

/// What every cell of closed_first is known to, most of them far better: this share of the lobe's
/// mean over the cells of its side, or of kFaintest [1/sr] where the lobe is fainter; the second
/// one where Lambertian flakes scatter.
inline constexpr double kFirstTolerance = 1e-6, kDiffuseTolerance = 1e-5, kFaintest = 1e-3;

/// Order 1 of one incident direction in closed form: no walk, no solved stack.
struct ClosedFirst {
  LobeEstimate up, down;  ///< cosine-weighted means of f [1/sr], [channel][cell]; errors are bounds
  /// The share of the light that meets nothing, where the stack is open below and no boundary makes
  /// deltas of its own.
  std::optional<double> uncollided;
};

/// Why closed_first has nothing on this stack, if it has nothing. It wants homogeneous layers, 16
/// at most, over a Lambertian substrate, a closed form, or none, and no interface that is rough.
/// Delta flakes are refused, as are Lambertian flakes that are tilted or under interfaces, whose
/// phase functions cost a quadrature per direction.
[[nodiscard]] std::optional<std::string> why_no_closed_first(const Stack& stack);

/// Both sides' cells of order 1 (`down` stays empty unless `both_sides`). Mirror flakes and
/// particles: the adaptive rule of volume/quadrature/cell_quadrature.h over each cell. Lambertian
/// flakes: modes in the azimuth (volume/kernel/lambert_flake_kernel.h), which columns of cells have
/// in closed form, by Gauss-Legendre panels over a row's cosines. The same for any number of
/// threads.
[[nodiscard]] ClosedFirst closed_first(const Stack& stack, const CellGrid& grid, Direction wi,
                                       int channels, bool both_sides);

}  // namespace lamella
