#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/quadrature/quadrature.h"

namespace lamella {

/// The directions that one solution works with: quadrature nodes first, then directions that are
/// asked for, which have no weight and so only receive the source function (out) or only send a
/// beam (in). All are |mu|; mu = 0 stands as kGrazingLimit.
struct DirectionSets {
  Eigen::VectorXd out, in;
  Eigen::VectorXd weight;  ///< of the nodes, for the integral over mu in (0, 1)
  Eigen::VectorXd flux;    ///< 2 pi mu weight: radiance of mode 0 to irradiance

  GrazingMap map;  ///< of the nodes

  DirectionSets(int nodes, const std::vector<double>& extra_out,
                const std::vector<double>& extra_in, const GrazingMap& grazing_map = {});

  [[nodiscard]] Eigen::Index nodes() const { return weight.size(); }
};

}  // namespace lamella
