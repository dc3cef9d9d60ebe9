#pragma once

#include <span>
#include <vector>

namespace lamella {

/// The modes f_M, f_(M + 1), ... beyond the last of a series, guessed from those before:
///   f_m = amplitude m^-exponent exp(-rate m).
struct ModeTail {
  double amplitude = 0, exponent = 0, rate = 0;
  int first = 0;
  double error = 0;  ///< bound of the sum of 2 |f_m| that is not accounted for

  /// f_m
  [[nodiscard]] double at(double m) const;
  /// Sum of 2 f_m cos(m x).
  [[nodiscard]] double sum(double x) const;
};

/// Fits modes 1/2 M, 3/4 M and M - 1. Near grazing reflection and straight transmission a steep
/// medium's modes are a smooth function of m, and the fit to 3/8, 1/2 and 5/8 M, held against mode
/// M - 1, tells how far the fit can be trusted. Series that are short, that change sign or grow get
/// no fit: the error is then an algebraic (or faster) decay's from the largest of the last four and
/// of four half way.
[[nodiscard]] ModeTail fit_mode_tail(std::span<const double> modes);

}  // namespace lamella
