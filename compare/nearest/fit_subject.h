#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compare/fit/bounded_least_squares.h"
#include "compare/nearest/fit_target.h"
#include "compare/nearest/free_parameters.h"

namespace lamella {

/// How closely means over cells are found: for searches, for the last one, and as comparisons have
/// them.
enum class FitPass { coarse, fine, exact };

/// What a fit changes: numbers, and the lobes that follow from them.
struct FitSubject {
  std::string name;
  std::vector<FreeNumber> free;
  /// Means of f over the cells of a target's lobes, [lobe][channel][cell], at scaled numbers;
  /// nothing where there are none. Smooth in the numbers over steps of `step`.
  std::function<std::optional<std::vector<double>>(std::span<const double> scaled, FitPass)> means;
  bool has_exact = true;            ///< FitPass::exact is another than `fine`
  double step = kUnitStep;          ///< half of what derivatives are taken over
  std::vector<double> own_error{};  ///< standard errors of the means, where they have some
  int starts = 4, tried = 24;       ///< searches, and points that these are the best of
  int steps = 40;                   ///< of the last search, at most
  double tolerance = 1e-10;         ///< relative change of the cost at which that ends
};

}  // namespace lamella
