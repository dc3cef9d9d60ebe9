#pragma once

#include <functional>
#include <string>
#include <vector>

#include "compare/request/run_monitor.h"

namespace lamella {

/// A way to layer a coat over a base, against the truth of one coat over Lambert's law: what comes
/// from the base (orders 1 and up), at two incident directions.
struct CoatAccuracy {
  std::string layering;           ///< of `coated`
  double ior, roughness, albedo;  ///< of the coat (roughness 0: smooth) and of the base
  /// Relative RMSE of the reflected lobe "1+" over 16 x 32 cells, at theta_i = 30 and 80 degrees.
  double at_30 = 0, at_80 = 0;
  double bound = 0;  ///< of the truth, relative to the mean over the azimuth
};

/// The coats that are measured: every index with every roughness and every albedo.
struct CoatRanges {
  std::vector<double> ior, roughness, albedo;
};
[[nodiscard]] CoatRanges coat_ranges(bool quick);

/// Facets scatter once, in the coats and in the truth, which the solver reaches to `tolerance` of a
/// cell. Ends after the stack at hand once the monitor stops.
void measure_coat_accuracy(bool quick, double tolerance, const RunMonitor& monitor,
                           const std::function<void(const CoatAccuracy&)>& report);

}  // namespace lamella
