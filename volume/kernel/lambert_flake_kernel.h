#pragma once

#include "phase/medium/sggx.h"
#include "phase/medium/vmf.h"
#include "volume/algebra/matrix_product.h"
#include "volume/kernel/kernel_modes.h"

namespace lamella {

/// Modes of Lambertian flakes with a vertical axis. The azimuth of the normal integrates two
/// clamped cosines to the product of their modes:
///   K_m = 2 integral over v = m.z in [-1, 1] of D(v) c_m(mu_i, v) c_m(mu_o, v) dv,
///   c_m(mu, v) = 1 / (2 pi) integral of max(0, mu v + sqrt(1 - mu^2) sqrt(1 - v^2) cos phi)
///   cos(m phi) dphi in closed form,
/// and one quadrature in v, with panels between the kinks of every c_m, serves all pairs.
[[nodiscard]] KernelModes lambert_flake_modes(const Sggx& ndf, const Eigen::VectorXd& out,
                                              const Eigen::VectorXd& in, int modes,
                                              const MatrixProduct& product);
[[nodiscard]] KernelModes lambert_flake_modes(const Vmf& ndf, const Eigen::VectorXd& out,
                                              const Eigen::VectorXd& in, int modes,
                                              const MatrixProduct& product);

/// K_m of one pair of signed cosines of w_o and w_i, for m < modes, by fewer points: the error of
/// their series is below kPairModesError of K_0. D must not be a delta.
inline constexpr double kPairModesError = 2e-6;
[[nodiscard]] Eigen::VectorXd lambert_flake_modes(const Sggx& ndf, double mu_o, double mu_i,
                                                  int modes);
[[nodiscard]] Eigen::VectorXd lambert_flake_modes(const Vmf& ndf, double mu_o, double mu_i,
                                                  int modes);

}  // namespace lamella
