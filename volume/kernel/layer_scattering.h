#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/kernel/azimuthal_kernel.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {

/// One medium at one albedo on the directions of `sets`. The quadrature's error in the conservation
/// of energy is removed by symmetric factors, K_ab -> d_a d_b K_ab, with which the white kernel's
/// discrete integral over w_o is sigma(w_i) to rounding (reciprocity stays exact).
struct LayerScattering {
  std::vector<Parts> modes;      ///< K_m with albedo and Schlick factor
  Eigen::VectorXd sigma_in[2];   ///< sigma(+mu), sigma(-mu) of `in`: light from above, below
  Eigen::VectorXd sigma_out[2];  ///< the same of `out`
  Eigen::VectorXd absorbing[2];  ///< sigma minus what is scattered, of `in`, without
                                 ///< cancellation: 0 at albedo 1
  bool two_sided = true;
  double correction = 0;  ///< largest |d - 1| at the nodes: small if they resolve K

  LayerScattering(const Medium& medium, double albedo, double f0, const DirectionSets& sets,
                  int modes, const MatrixProduct& product = MatrixProduct());
  /// Particles with that kernel: sigma = 1, the same from both sides.
  LayerScattering(KernelModes kernel, double albedo, const DirectionSets& sets);

 private:
  void conserve_energy(KernelModes kernel, double albedo, double f0, const DirectionSets& sets);
};

}  // namespace lamella
