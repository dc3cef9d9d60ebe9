#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/azimuthal_kernel.h"

namespace lamella {

/// The directions that one solution works with: quadrature nodes first, then directions that are
/// asked for, which have no weight and so only receive the source function (out) or only send a
/// beam (in). All are |mu|; mu = 0 stands as kGrazingLimit.
struct DirectionSets {
  Eigen::VectorXd out, in;
  Eigen::VectorXd weight;  ///< of the nodes, for the integral over mu in (0, 1)
  Eigen::VectorXd flux;    ///< 2 pi mu weight: radiance of mode 0 to irradiance

  DirectionSets(int nodes, const std::vector<double>& extra_out,
                const std::vector<double>& extra_in);

  [[nodiscard]] Eigen::Index nodes() const { return weight.size(); }
};

/// One medium at one albedo on those directions. The quadrature's error in the conservation of
/// energy is removed by symmetric factors, K_ab -> d_a d_b K_ab, with which the white kernel's
/// discrete integral over w_o is sigma(w_i) to rounding (reciprocity stays exact).
struct LayerScattering {
  std::vector<Parts> modes;              ///< K_m with albedo and Schlick factor
  Eigen::VectorXd sigma_in[2];           ///< sigma(+mu), sigma(-mu) of `in`: light from above, below
  Eigen::VectorXd sigma_out[2];          ///< the same of `out`
  Eigen::VectorXd absorbing[2];          ///< sigma minus what is scattered, of `in`, without
                                         ///< cancellation: 0 at albedo 1
  bool two_sided = true;
  double correction = 0;                 ///< largest |d - 1| at the nodes: how well they resolve K

  LayerScattering(const Medium& medium, double albedo, double f0, const DirectionSets& sets,
                  int modes);
};

}  // namespace lamella
