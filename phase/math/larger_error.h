#pragma once

#include <cmath>

namespace lamella {

/// The larger of two errors (any unit, >= 0 or infinite); not a number where either is not.
/// std::max and bare comparisons turn an error that is unknown into the other one.
[[nodiscard]] inline double larger_error(double a, double b) {
  return a >= b || std::isnan(a) ? a : b;
}

}  // namespace lamella
