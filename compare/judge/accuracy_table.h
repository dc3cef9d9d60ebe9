#pragma once

#include <functional>
#include <string>
#include <vector>

#include "compare/request/run_monitor.h"

namespace lamella {

/// The error of a closed form against the solved truth of one stack that it claims to describe, at
/// the default incident directions (theta_i = 0, 30, 60, 80 degrees), all orders, each side by
/// itself.
struct ModelAccuracy {
  std::string family;  ///< of stacks, in words
  std::string stack;   ///< the parameters that vary within it
  std::string model;
  std::vector<double> reflected;    ///< relative RMSE of the reflected lobe, per incident direction
  std::vector<double> transmitted;  ///< the same, transmitted; empty where nothing comes through
  double energy_off = 0;            ///< largest |energy of the model - of the truth| of a side
  double bound = 0;                 ///< of the truth, relative to the mean over the azimuth
};

/// Every closed form that claims a medium, over its parameters, against the deterministic solver on
/// 16 x 32 cells, to the tolerance, to 1e-4 under coats and 1e-6 of flakes that lean or lie, which
/// take a minute or two each. `quick`: the first stack of each family, of those that are symmetric
/// about the normal. Ends after the stack at hand once the monitor stops.
void measure_model_accuracy(bool quick, double tolerance, const RunMonitor& monitor,
                            const std::function<void(const ModelAccuracy&)>& report);

}  // namespace lamella
