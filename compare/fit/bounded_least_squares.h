#pragma once

#include <functional>
#include <span>
#include <vector>

namespace lamella {

/// Half of the interval that derivatives are taken over, in scaled parameters: central differences
/// with an error of its square times the third derivative.
inline constexpr double kUnitStep = 1e-4;

/// Least squares over the unit cube: parameters are scaled to [0, 1] by the caller.
struct UnitProblem {
  int parameters = 0, residuals = 0;
  /// Writes the residuals at x; false where there are none, which ends a step.
  std::function<bool(std::span<const double> x, std::span<double> residuals)> evaluate;
  double step = kUnitStep;
};

struct UnitEffort {
  int iterations = 60;
  double tolerance = 1e-8;  ///< relative change of the cost at which the search ends
  /// Asked after every step: whether it is to be the last one.
  std::function<bool()> stop{};
};

struct UnitMinimum {
  std::vector<double> x;
  double cost = 0;  ///< half the sum of the squares
  std::vector<double> residuals;
  std::vector<double> jacobian;  ///< [residual][parameter], of the scaled parameters
  int iterations = 0;
};

/// The local minimum that Levenberg and Marquardt's method (Ceres) finds from `start`, within the
/// cube. Equal input gives equal output, for any number of threads. Throws std::domain_error where
/// `start` has no residuals.
[[nodiscard]] UnitMinimum minimum_from(const UnitProblem& problem, std::vector<double> start,
                                       const UnitEffort& effort);

}  // namespace lamella
