#pragma once

#include <Eigen/Core>

namespace lamella {

/// Radiance through the two faces of a block, or at one of its faces in two directions. Rows:
/// cosines; columns: azimuths of the way that the light goes, or their waves 1, sqrt(2) cos(m phi),
/// sqrt(2) sin(m phi), m = 1, 2, ...
struct FaceLight {
  Eigen::MatrixXd down, up;
};

/// Values of the waves (columns) at azimuths (rows).
[[nodiscard]] Eigen::MatrixXd azimuthal_waves(Eigen::Index waves, const Eigen::VectorXd& phi);

}  // namespace lamella
