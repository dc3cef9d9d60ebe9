#pragma once

#include <string>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// Where a model is farthest from energy 1 below or above.
struct SweepExtreme {
  double energy = 1;
  double theta = 0;          ///< degrees
  std::string parameters{};  ///< "key=value, ..."
};

/// A parameter that takes more than one value, as text.
struct FurnaceSweepAxis {
  std::string name;
  std::vector<std::string> values;
};

struct FurnaceSweep {
  int configurations = 0;
  std::vector<FurnaceSweepAxis> axes{};
  /// One per configuration and incident angle: [configuration][theta], the first axis changing
  /// fastest.
  std::vector<double> energies{};
  SweepExtreme least{.energy = 2}, most{.energy = -1};
  /// The largest error of an energy: of its quadrature or closed form, or of a stochastic model one
  /// standard error.
  double worst_error = 0;
};

/// The white furnace of a model over the whole range of its parameters: albedo and f0 at 1, every
/// other number at five steps of its range (a range that has no end, or belongs to the evaluation
/// or to a bulk, stays at its default), `surface` at all its choices; energy at mu = 1, 0.9, 0.6,
/// 0.3, 0.1, 0.02 and 0.
[[nodiscard]] FurnaceSweep sweep_furnace(const ModelInfo& info);

/// Its incident angles in degrees.
[[nodiscard]] std::vector<double> furnace_sweep_angles();

}  // namespace lamella
